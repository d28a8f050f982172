// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Sparse normal equations H δ = g over block variables: order and layout once, values as often as needed.

#include <Eigen/Core>
#include <functional>
#include <mapjoin/solve/block_pattern.hpp>
#include <mapjoin/solve/sparse_solver.hpp>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// Normal equations of a BlockPattern, and their solution by an engine. Vectors are over the variables in the pattern's own
/// order, dof(v) entries each.
class NormalEquations {
 public:
  explicit NormalEquations(BlockPattern pattern, Engine engine = Engine::kFronts, const Ordering& ordering = {})
      : NormalEquations(std::move(pattern), make_solver(engine), ordering) {}
  NormalEquations(BlockPattern pattern, std::unique_ptr<SparseSolver> solver, const Ordering& ordering);

  /// Adds the blocks of one factor, over its variables in their order, to H and g.
  class Sink {
   public:
    /// Adds the block of variables i ≤ j.
    template <typename Block>
    void hessian(int i, int j, const Block& block) {
      const Variable a = variables_[static_cast<std::size_t>(i)];
      const Variable b = variables_[static_cast<std::size_t>(j)];
      if (a == kConstant || b == kConstant) return;
      auto& [order, column, H] = equations_.elimination_;
      const Column first = std::min(column[a], column[b]);
      double* to = H.values.data() + (a == b ? H.first_value[first] : value_offsets_[j * (j - 1) / 2 + i]);
      const auto values = block.eval();
      if (column[a] >= column[b]) {
        add(first, to, H.heights[first], values);
      } else {
        add(first, to, H.heights[first], values.transpose());
      }
    }
    template <typename Block>
    void rhs(int i, const Block& block) {
      const Variable v = variables_[static_cast<std::size_t>(i)];
      if (v == kConstant) return;
      add(equations_.elimination_.column[v], equations_.gradient_.data() + equations_.offset(v), equations_.dof(v), block);
    }

   private:
    friend NormalEquations;
    /// Additions to columns of other parts, made later.
    struct Waiting {
      struct Block {
        double* to;
        Eigen::Index rows, columns, stride;
      };
      std::vector<Block> blocks;
      std::vector<double> values;  // block after block
    };

    Sink(NormalEquations& equations, std::size_t factor, IndexRange<Column> own, Waiting* waiting)
        : equations_(equations),
          variables_(equations.pattern_.factors[factor]),
          value_offsets_(equations.value_offsets_[factor].data()),
          own_(own),
          waiting_(waiting) {}
    template <typename Block>
    void add(Column column, double* to, Eigen::Index stride, const Block& block) {
      constexpr int kRows = Block::RowsAtCompileTime;
      constexpr int kColumns = Block::ColsAtCompileTime;
      using Values = Eigen::Matrix<double, kRows, kColumns>;
      if (own_.contains(column)) {
        Eigen::Map<Values, 0, Eigen::OuterStride<>>(to, block.rows(), block.cols(), Eigen::OuterStride<>(stride)) += block;
        return;
      }
      waiting_->blocks.push_back({to, block.rows(), block.cols(), stride});
      const std::size_t begin = waiting_->values.size();
      waiting_->values.resize(begin + static_cast<std::size_t>(block.size()));
      Eigen::Map<Values>(waiting_->values.data() + begin, block.rows(), block.cols()) = block;
    }

    NormalEquations& equations_;
    std::span<const Variable> variables_;
    const std::int64_t* value_offsets_;
    IndexRange<Column> own_;
    Waiting* waiting_;  // additions to columns that are not own; null if all are
  };

  void set_zero();
  Sink sink(std::size_t factor) { return {*this, factor, matrix().columns(), nullptr}; }
  /// Calls f(factor, sink) for every factor, on all threads, and returns the sum of its results. All sums are the same for any
  /// number of threads.
  double accumulate_factors(const std::function<double(std::size_t, Sink)>& f);
  /// Adds to the diagonal block of a variable.
  void add_diagonal(Variable v, const Eigen::MatrixXd& block);

  const BlockPattern& pattern() const { return pattern_; }
  const Table<Column, Variable>& order() const { return elimination_.order; }
  /// H in elimination order.
  const BlockLower& matrix() const { return elimination_.matrix; }
  IndexRange<Variable> variables() const { return indices(pattern_.dofs); }
  int dof(Variable v) const { return pattern_.dofs[v]; }
  /// The first entry of a variable in vectors; size() for the one after the last.
  Eigen::Index offset(Variable v) const { return offsets_[v]; }
  Eigen::Index size() const { return offsets_.back(); }
  const Eigen::VectorXd& gradient() const { return gradient_; }
  Eigen::VectorXd diagonal() const { return to_variables(matrix().diagonal()); }
  /// vᵀ H v.
  double curvature(const Eigen::VectorXd& v) const;
  /// The least wᵀ H w over all w that equal v in the given variables: the squared Mahalanobis length of these entries of v
  /// under their joint covariance, a block of H⁻¹. Factorises H over the other variables; nullopt if that is singular.
  std::optional<double> least_curvature(const Eigen::VectorXd& v, const Table<Variable, bool>& is_given) const;

  /// Replaces H by H + damping·diag(H).
  void damp(double damping);
  /// Factorises H + damping·diag(H); H stays as it is. Returns a variable at which it is singular, or nullopt.
  std::optional<Variable> factorise(double damping);
  /// The directions in which a singular H leaves the variables free, as columns: at most `most_count` of a basis of its null
  /// space. Makes a factorisation of its own.
  Eigen::MatrixXd null_space(std::size_t most_count) const;
  /// (H + damping·diag(H))⁻¹ b by the last factorisation.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const { return solve_columns(b); }
  /// Performs solve() for every column of B.
  Eigen::MatrixXd solve_columns(const Eigen::MatrixXd& B) const;

  /// The factor L of the last factorisation; valid until the next one.
  Supernodes supernodes() const { return solver_->supernodes(); }
  /// The supernode of L that has a column; valid until the next factorisation.
  Supernode supernode_of(std::int64_t column) const { return solver_->supernode_of(column); }
  /// The number of supernodes of L, the same for every factorisation.
  std::size_t supernode_count() const { return solver_->supernode_count(); }
  /// Memory of L's values (bytes).
  std::int64_t factor_bytes() const { return solver_->bytes(); }
  /// The column of L at which a variable begins.
  std::int64_t factor_column(Variable v) const { return matrix().offsets[elimination_.column[v]]; }
  /// Rows over the variables, taken to elimination order, and back.
  Eigen::MatrixXd to_columns(const Eigen::MatrixXd& rows) const;
  Eigen::MatrixXd to_variables(const Eigen::MatrixXd& rows) const;

 private:
  /// A part of the factors: those whose first column is one of the part's own.
  struct Part {
    IndexRange<Column> own;
    std::vector<std::uint32_t> factors;
  };
  void find_value_offsets();
  void share_out_factors();

  BlockPattern pattern_;
  Elimination elimination_;  ///< Its matrix is H.
  Table<Variable, Eigen::Index> offsets_;
  Lists<std::size_t, std::int64_t> value_offsets_;  ///< Per factor, of blocks in H's values: variables i < j at j(j-1)/2 + i.
  std::vector<Part> parts_;
  Eigen::VectorXd gradient_;
  std::unique_ptr<SparseSolver> solver_;
};

}  // namespace mapjoin
