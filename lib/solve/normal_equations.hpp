// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Sparse normal equations H δ = g over block variables: pattern, ordering and destinations once, values as often as needed.

#include <Eigen/Core>
#include <algorithm>
#include <functional>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <mapjoin/solve/sparse_solver.hpp>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace mapjoin {

/// A variable that is held still: it has no columns.
inline constexpr Index kConstant = -1;

/// Which variables each observation ties together: its slots, kConstant where the slot is held still.
struct Cliques {
  std::vector<std::int64_t> begin = {0};
  std::vector<Index> variables;

  std::size_t size() const { return begin.size() - 1; }
  std::span<const Index> operator[](std::size_t clique) const {
    return {variables.data() + begin[clique], static_cast<std::size_t>(begin[clique + 1] - begin[clique])};
  }
  template <typename Range>
  void push_back(const Range& slots) {
    variables.insert(variables.end(), slots.begin(), slots.end());
    begin.push_back(static_cast<std::int64_t>(variables.size()));
  }
};

/// Vectors are over the variables in their own order, `dofs[v]` entries each.
class NormalEquations {
 public:
  NormalEquations(std::vector<int> dofs, Cliques cliques, Engine engine = Engine::kFronts)
      : NormalEquations(std::move(dofs), std::move(cliques), make_solver(engine)) {}
  /// Without a solver there are but the pattern and its order, matrix(), which the caller factorises.
  NormalEquations(std::vector<int> dofs, Cliques cliques, std::unique_ptr<SparseSolver> solver, const Ordering& ordering = {});

  /// Takes the blocks of one observation to their destinations.
  class Sink {
   public:
    template <typename Block>
    void hessian(int i, int j, const Block& block) {
      const Index a = slots_[static_cast<std::size_t>(i)];
      const Index b = slots_[static_cast<std::size_t>(j)];
      if (a == kConstant || b == kConstant) return;
      if (i == j && is_elsewhere(i)) {
        add_to_sums(sums_[static_cast<std::size_t>(i)], block);
      } else {
        equations_.add(a, b, i == j ? 0 : destinations_[j * (j - 1) / 2 + i], block);
      }
    }
    template <typename Block>
    void rhs(int i, const Block& block) {
      const Index a = slots_[static_cast<std::size_t>(i)];
      if (a == kConstant) return;
      if (is_elsewhere(i)) {
        add_to_sums(sums_[static_cast<std::size_t>(i)] + equations_.dof(a) * equations_.dof(a), block);
      } else {
        equations_.add_rhs(a, block);
      }
    }

   private:
    friend NormalEquations;
    Sink(NormalEquations& equations, std::size_t clique, double* elsewhere = nullptr)
        : equations_(equations),
          slots_(equations.cliques_[clique]),
          destinations_(equations.destinations_.data() + equations.destination_begin_[clique]),
          sums_(equations.sums_.data() + equations.cliques_.begin[clique]),
          elsewhere_(elsewhere) {}
    bool is_elsewhere(int i) const { return elsewhere_ && sums_[static_cast<std::size_t>(i)] != kOwn; }
    template <typename Block>
    void add_to_sums(std::int32_t begin, const Block& block) {
      const auto value = block.eval();
      Eigen::Map<std::remove_const_t<decltype(value)>>(elsewhere_ + begin, value.rows(), value.cols()) += value;
    }

    NormalEquations& equations_;
    std::span<const Index> slots_;
    const std::int64_t* destinations_;
    const std::int32_t* sums_;
    double* elsewhere_;  // sums of what other parts own, or null where everything is added in its place
  };

  void set_zero();
  Sink sink(std::size_t clique) { return {*this, clique}; }
  /// Calls f(clique, sink) for every clique, on all threads, and returns the sum of what it returns. All sums are the same for
  /// any number of threads.
  double accumulate_cliques(const std::function<double(std::size_t, Sink)>& f);

  /// H in the order of its elimination: variable v is block place(v).
  const BlockLower& matrix() const { return matrix_; }
  Index place(Index v) const { return place_[static_cast<std::size_t>(v)]; }
  /// Vectors over the variables, side by side, in that order.
  Eigen::MatrixXd permuted(const Eigen::MatrixXd& columns) const;

  /// Adds to the block of one variable with itself.
  template <typename Block>
  void add_diagonal(Index v, const Block& block) {
    add(v, v, 0, block);
  }

  std::span<const Index> clique(std::size_t clique) const { return cliques_[clique]; }
  /// The variable at each place of the elimination.
  const std::vector<Index>& order() const { return order_; }
  Eigen::Index size() const { return offsets_.back(); }
  Index variable_count() const { return static_cast<Index>(dofs_.size()); }
  /// Where the entries of variable v begin.
  Eigen::Index offset(Index v) const { return offsets_[static_cast<std::size_t>(v)]; }
  const Eigen::VectorXd& gradient() const { return gradient_; }
  Eigen::VectorXd diagonal() const;
  /// vᵀ H v.
  double curvature(const Eigen::VectorXd& v) const;
  /// The least wᵀ H w over all w that are v in the given variables (those of `is_given`): the squared Mahalanobis length of
  /// these entries of v under their joint covariance, a block of H⁻¹. Nothing where that is singular. By a factorisation over
  /// the other variables.
  std::optional<double> least_curvature(const Eigen::VectorXd& v, const std::vector<bool>& is_given) const;

  /// H + damping·diag(H) from here on.
  void damp(double damping) { set_diagonal((1.0 + damping) * diagonal()); }
  /// Factorises H + damping·diag(H), H staying what it is. Returns a variable at which it is singular, or nothing.
  std::optional<Index> factorise(double damping);
  /// The directions in which H leaves the variables free where it is singular, as columns: at most `most_count` of a basis of
  /// its null space. By a factorisation of its own.
  Eigen::MatrixXd null_space(std::size_t most_count) const;
  /// (H + damping·diag(H))⁻¹ b of the last factorisation.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const { return solve_columns(b); }
  /// The same for every column of B.
  Eigen::MatrixXd solve_columns(const Eigen::MatrixXd& B) const;

  /// The factor L of the last factorisation, whose columns are those of column_of(); it holds until the next one.
  Supernodes supernodes() const { return solver_->supernodes(); }
  /// How many there are, of any factorisation.
  std::size_t supernode_count() const { return solver_->supernode_count(); }
  /// Memory of its values.
  std::int64_t factor_bytes() const { return solver_->bytes(); }
  /// The column of the factorised matrix at which variable v begins.
  std::int64_t column_of(Index v) const { return matrix_.offsets[static_cast<std::size_t>(place(v))]; }
  int dof(Index v) const { return dofs_[static_cast<std::size_t>(v)]; }

 private:
  void set_diagonal(const Eigen::VectorXd& diagonal);
  void order_and_lay_out(const Ordering& ordering);
  template <typename F>
  void for_each_neighbour(Index v, std::span<const std::uint32_t> cliques, F&& f) const;
  void find_destinations();
  /// H over the places at which `is_kept`, in the order of the elimination.
  BlockLower principal_submatrix(const std::vector<bool>& is_kept) const;
  /// H v; both in the order of the elimination.
  Eigen::VectorXd product(const Eigen::VectorXd& v) const;
  /// And back.
  Eigen::MatrixXd unpermuted(const Eigen::MatrixXd& columns) const;

  /// The cliques of two slots whose first place is in one run of places, and their variables at other places. What adds to
  /// these waits in sums until nobody else writes: per variable its diagonal block, then its right-hand side.
  struct Part {
    std::vector<std::uint32_t> cliques;
    std::vector<std::pair<Index, std::int32_t>> others;  ///< Each with where its sums begin.
    std::int32_t sums = 0;
  };
  /// A slot whose variable is of the clique's part.
  static constexpr std::int32_t kOwn = -1;
  void share_out_cliques();
  void colour_large_cliques();
  /// The part of each place.
  std::vector<std::uint32_t> cut_places(const std::vector<Index>& first_places);

  template <typename Block>
  void add_rhs(Index v, const Block& block) {
    gradient_.segment(offset(v), block.size()) += block;
  }
  template <typename Expression>
  void add(Index a, Index b, std::int64_t destination, const Expression& expression) {
    const auto block = expression.eval();
    using Block = std::remove_const_t<decltype(block)>;
    const Index place_a = place(a);
    const Index place_b = place(b);
    constexpr int kRows = Block::RowsAtCompileTime;
    constexpr int kCols = Block::ColsAtCompileTime;
    using Stride = Eigen::OuterStride<>;
    const auto column = static_cast<std::size_t>(std::min(place_a, place_b));
    if (a == b) destination = matrix_.first_value[column];
    const Stride stride(matrix_.heights[column]);
    double* values = matrix_.values.data() + destination;
    if (place_a >= place_b) {
      Eigen::Map<Eigen::Matrix<double, kRows, kCols>, 0, Stride>(values, block.rows(), block.cols(), stride) += block;
    } else {
      Eigen::Map<Eigen::Matrix<double, kCols, kRows>, 0, Stride>(values, block.cols(), block.rows(), stride) +=
          block.transpose();
    }
  }

  std::vector<int> dofs_;
  Cliques cliques_;
  std::vector<Eigen::Index> offsets_;  ///< Per variable, in its own order, and the total.
  std::vector<Index> order_;           ///< Variable at each place of the elimination.
  std::vector<Index> place_;           ///< Place of each variable.
  std::vector<std::int64_t> destination_begin_;
  std::vector<std::int64_t> destinations_;  ///< Per clique, of slots i < j at j(j-1)/2 + i.
  std::vector<Part> parts_;
  /// Cliques of more than two slots, by colour: those of one colour have no variable in common, but for the last colour.
  std::vector<std::vector<std::uint32_t>> large_cliques_;
  std::vector<std::int32_t> sums_;  ///< Per slot of all cliques, where the sums of its part begin, or kOwn.
  BlockLower matrix_;               ///< H, by places.
  Eigen::VectorXd gradient_;
  std::unique_ptr<SparseSolver> solver_;
};

}  // namespace mapjoin
