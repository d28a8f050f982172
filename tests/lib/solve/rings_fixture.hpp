// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Normal equations beside the dense inverse of their H.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <mapjoin/solve/normal_equations.hpp>
#include <string>
#include <tests/support/random.hpp>
#include <vector>

namespace mapjoin::testing {

struct Rings {
  int variables;
  int rings;
  Engine engine = Engine::kFronts;
};

/// Normal equations over variables of 3 and of 2 entries in rings, which nothing ties to each other, and the dense matrix of
/// the same blocks. Observations tie three variables of a ring: neighbours, and one across.
class RingsTest : public ::testing::TestWithParam<Rings> {
 protected:
  RingsTest() {
    BlockPattern pattern;
    for (int v = 0; v < count; ++v) pattern.dofs.push_back(v % 2 == 0 ? 3 : 2);
    for (int v = 0; v < count; ++v) pattern.factors.push_back(std::array{Variable(v), on_ring(v, 1, 1), on_ring(v, 7, 3)});
    equations = NormalEquations(pattern, GetParam().engine);
    H = Eigen::MatrixXd::Zero(equations.size(), equations.size());
    equations.set_zero();
    for (std::size_t f = 0; f < pattern.factors.size(); ++f) add_factor(f);
    inverse = H.inverse();
  }

  /// The variable at place a·k + b of the ring in which v is at place k.
  Variable on_ring(int v, int a, int b) const {
    const int rings = GetParam().rings;
    return Variable((a * (v / rings) + b) % (count / rings) * rings + v % rings);
  }
  void add_factor(std::size_t factor) {
    const auto variables = equations.pattern().factors[factor];
    auto sink = equations.sink(factor);
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i <= j; ++i) {
        const Variable a = variables[static_cast<std::size_t>(i)];
        const Variable b = variables[static_cast<std::size_t>(j)];
        if (a == b && i != j) continue;
        const Eigen::MatrixXd block = information(equations.dof(a), equations.dof(b), i == j);
        sink.hessian(i, j, block);
        H.block(equations.offset(a), equations.offset(b), block.rows(), block.cols()) += block;
        if (i != j) H.block(equations.offset(b), equations.offset(a), block.cols(), block.rows()) += block.transpose();
      }
    }
  }
  /// A random block; those on the diagonal outweigh the others, so that H is positive definite.
  Eigen::MatrixXd information(int rows, int cols, bool is_diagonal) {
    if (is_diagonal) return 6.0 * Eigen::MatrixXd::Identity(rows, cols);
    Eigen::MatrixXd block(rows, cols);
    for (auto& entry : block.reshaped()) entry = random.uniform(-1.0, 1.0);
    return block;
  }
  std::vector<Eigen::Index> entries(const std::vector<Variable>& variables) const {
    std::vector<Eigen::Index> list;
    for (const Variable v : variables) {
      for (int i = 0; i < equations.dof(v); ++i) list.push_back(equations.offset(v) + i);
    }
    return list;
  }
  Eigen::MatrixXd inverse_over(const std::vector<Variable>& variables) const {
    return inverse(entries(variables), entries(variables));
  }

  const int count = GetParam().variables;
  Random random;
  NormalEquations equations{{}};
  Eigen::MatrixXd H;
  Eigen::MatrixXd inverse;
};

inline const auto kRings = ::testing::Values(Rings{7, 1}, Rings{40, 1}, Rings{300, 1}, Rings{60, 3},
                                             Rings{40, 1, Engine::kCholmod}, Rings{60, 3, Engine::kCholmod});

inline std::string name_of_rings(const ::testing::TestParamInfo<Rings>& info) {
  return fmt::format("{}in{}by_{}", info.param.variables, info.param.rings, to_string(info.param.engine));
}

}  // namespace mapjoin::testing
