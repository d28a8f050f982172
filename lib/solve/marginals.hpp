// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Covariances of variables that one observation ties together: the blocks of H⁻¹ on the pattern of its Cholesky factor.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mapjoin/solve/normal_equations.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// The entries of A⁻¹ on the pattern of its Cholesky factor, without the others.
///
/// For a supernode J with the rows R below it and G = L_RJ L_JJ⁻¹, A⁻¹ = L⁻ᵀ L⁻¹ gives (Takahashi, Fagan and Chin, 1973;
/// Erisman and Tinney, 1975)
///
///   Z_RJ = -Z_RR G,    Z_JJ = L_JJ⁻ᵀ L_JJ⁻¹ + Gᵀ Z_RR G.
///
/// Any two rows of R are in the pattern, too, in columns after J: one sweep from the last supernode to the first suffices, at
/// about twice the cost of the factorisation.
class InverseSubset {
 public:
  /// A callback with the number of supernodes done; false ends the work there, and the rest of the subset is zero.
  using GoOn = std::function<bool(std::size_t)>;
  /// Computes the subset; `factor` may go afterwards. Throws std::bad_alloc when memory runs out.
  explicit InverseSubset(const Supernodes& factor, const GoOn& go_on = nullptr);
  InverseSubset(InverseSubset&&) = default;
  InverseSubset& operator=(InverseSubset&&) = default;

  /// The memory that the constructor needs (bytes).
  static std::int64_t bytes(const Supernodes& factor);

  /// The block of A⁻¹ over some of its columns, in the order given. Throws std::out_of_range unless any two of them are coupled
  /// in L, as those are that one observation ties together.
  Eigen::MatrixXd block(std::span<const std::int64_t> columns) const;

 private:
  struct Node {
    std::int64_t begin;
    std::int64_t end;
    std::span<const std::int64_t> rows;  // in rows_
    double* values;                      // in values_, laid out as in Supernode; the lower triangle of Z
  };
  /// Workspace for one supernode.
  struct Workspace {
    std::vector<std::int64_t> positions;
    std::vector<double> U;  // L_JJ⁻ᵀ
    std::vector<double> minus_U;
    std::vector<double> G_transposed;
    std::vector<double> Z_RR;
    std::vector<double> Z_JR;
  };
  void invert(const Supernode& L, const Node& node, Workspace& workspace) const;
  /// Gathers the lower triangle of Z over ascending columns of L that are coupled with each other.
  void gather(std::span<const std::int64_t> places, std::vector<std::int64_t>& positions, double* out) const;

  std::vector<std::int64_t> rows_;
  std::vector<double> values_;
  std::vector<Node> nodes_;
  std::vector<std::int32_t> node_of_;  // per column
};

/// The blocks of H⁻¹ on the pattern of the factor: every variable, and every pair that one observation ties together.
class Marginals {
 public:
  /// Uses the last factorisation; `equations` may go afterwards. See InverseSubset for memory and `go_on`.
  explicit Marginals(const NormalEquations& equations, const InverseSubset::GoOn& go_on = nullptr);

  /// The memory that the constructor needs (bytes).
  static std::int64_t bytes(const NormalEquations& equations);

  /// The joint covariance of variables, in the order given. Throws std::out_of_range unless every two of them are in the
  /// pattern.
  Eigen::MatrixXd joint(std::span<const Variable> variables) const;
  Eigen::MatrixXd operator[](Variable variable) const { return joint({&variable, 1}); }

 private:
  /// The columns of a variable in the factor.
  struct Columns {
    std::int64_t first;
    std::int64_t count;
  };

  Table<Variable, Columns> columns_;
  InverseSubset subset_;
};

}  // namespace mapjoin
