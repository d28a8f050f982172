// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <atomic>
#include <mapjoin/solve/factor_tasks.hpp>
#include <mapjoin/solve/frontal_matrix.hpp>
#include <mapjoin/solve/pivot.hpp>
#include <mapjoin/solve/sparse_cholesky.hpp>

namespace mapjoin {
namespace {

using Eigen::Lower;
using Stride = Eigen::OuterStride<>;

/// One factorisation: the updates on their way from supernode to parent.
class Factorisation {
 public:
  Factorisation(const SupernodalTree& tree, const BlockLower& matrix, double* values)
      : tree_(tree), matrix_(matrix), values_(values), updates_(tree.nodes.size()), first_singular_(matrix.size()) {}

  std::optional<std::int64_t> run() {
    for_each_upwards(tree_.tasks, [this](std::size_t s) {
      // Columns behind a singular one may not be worked out; those before it always are.
      if (matrix_.offsets[tree_.nodes[s].columns.begin] < first_singular_) eliminate_node(s);
    });
    const std::int64_t column = first_singular_;
    return column < matrix_.size() ? std::optional(column) : std::nullopt;
  }

 private:
  void eliminate_node(std::size_t s) {
    const FactorNode& node = tree_.nodes[s];
    const Eigen::Index below = node.below();
    updates_[s] = std::make_unique_for_overwrite<double[]>(static_cast<std::size_t>(below * below));
    const FrontalMatrix front{{values_ + node.first_value, node.height, node.width, Stride(node.height)},
                              {updates_[s].get(), below, below, Stride(below)}};
    take_entries(node, front.panel);
    add_children(node, 0, front.panel);
    const auto singular = eliminate(front);
    note_singular(node, front.panel, singular.value_or(node.width), singular.has_value());
    if (singular) return;
    add_children(node, node.width, front.update);  // which the elimination has overwritten
    for (const std::size_t c : tree_.children_of(node)) updates_[c].reset();
  }

  /// What the children send, as far as it belongs to a block that begins at row and column `begin` of the front.
  void add_children(const FactorNode& node, Eigen::Index begin, DenseBlock block) const {
    for (const std::size_t c : tree_.children_of(node)) {
      const Eigen::Index size = tree_.nodes[c].below();
      add_update({updates_[c].get(), size, size, Stride(size)}, tree_.runs_of(tree_.nodes[c]), begin, block);
    }
  }

  /// The panel is what the matrix has there.
  void take_entries(const FactorNode& node, DenseBlock panel) const {
    panel.setZero();
    Eigen::Index column = 0;
    for (std::size_t k = node.columns.begin; k < node.columns.end; ++k) {
      const double* from = matrix_.values.data() + matrix_.first_value[k];
      for (Eigen::Index j = 0; j < matrix_.dof(k); ++j, ++column) {
        for (auto entry = matrix_.begin[k]; entry < matrix_.begin[k + 1]; ++entry) {
          const auto e = static_cast<std::size_t>(entry);
          const Eigen::Index rows = matrix_.dof(static_cast<std::size_t>(matrix_.rows[e]));
          std::copy_n(from, rows, panel.data() + tree_.front_rows[e] + column * panel.outerStride());
          from += rows;
        }
      }
    }
  }

  /// Of the columns before `regular`, the first whose pivot has lost its digits is singular; then that one, if it is.
  void note_singular(const FactorNode& node, DenseBlock panel, Eigen::Index regular, bool is_singular) {
    Eigen::Index column = 0;
    for (std::size_t k = node.columns.begin; k < node.columns.end; ++k) {
      for (Eigen::Index i = 0; i < matrix_.dof(k) && column < regular; ++i, ++column) {
        if (!has_lost_digits(panel(column, column), matrix_.diagonal(k, i))) continue;
        regular = column;
        is_singular = true;
      }
    }
    if (!is_singular) return;
    const std::int64_t found = matrix_.offsets[node.columns.begin] + regular;
    std::int64_t first = first_singular_;
    while (found < first && !first_singular_.compare_exchange_weak(first, found)) {
    }
  }

  const SupernodalTree& tree_;
  const BlockLower& matrix_;
  double* values_;
  std::vector<std::unique_ptr<double[]>> updates_;  ///< Per supernode, until its parent has taken it.
  std::atomic<std::int64_t> first_singular_;
};

}  // namespace

void SparseCholesky::analyse(const BlockLower& matrix) {
  tree_ = supernodal_tree(matrix);
  offsets_ = matrix.offsets;
  values_.reset();
}

std::optional<std::int64_t> SparseCholesky::factorise(const BlockLower& matrix) {
  if (!values_) values_ = std::make_unique_for_overwrite<double[]>(static_cast<std::size_t>(tree_.value_count));
  return Factorisation(tree_, matrix, values_.get()).run();
}

Eigen::MatrixXd SparseCholesky::solve_columns(Eigen::MatrixXd B) const {
  std::vector<Eigen::MatrixXd> updates(tree_.nodes.size());  // what each supernode takes off the rows below it
  const auto panel = [&](const FactorNode& node) {
    return ConstDenseBlock(values_.get() + node.first_value, node.height, node.width, Stride(node.height));
  };
  for_each_upwards(tree_.tasks, [&](std::size_t s) {
    const FactorNode& node = tree_.nodes[s];
    auto own = B.middleRows(offsets_[node.columns.begin], node.width);
    updates[s].setZero(node.below(), B.cols());
    for (const std::size_t c : tree_.children_of(node)) {
      for (const RowRun& run : tree_.runs_of(tree_.nodes[c])) {
        const auto from = updates[c].middleRows(run.from, run.length);
        const Eigen::Index in_own = std::clamp<Eigen::Index>(node.width - run.to, 0, run.length);
        own.middleRows(std::min<Eigen::Index>(run.to, node.width), in_own) += from.topRows(in_own);
        updates[s].middleRows(std::max<Eigen::Index>(run.to - node.width, 0), run.length - in_own) +=
            from.bottomRows(run.length - in_own);
      }
      updates[c].resize(0, 0);
    }
    const auto L = panel(node);
    L.topRows(node.width).triangularView<Lower>().solveInPlace(own);
    updates[s].noalias() -= L.bottomRows(node.below()) * own;
  });
  for_each_downwards(tree_.tasks, [&](std::size_t s) {
    const FactorNode& node = tree_.nodes[s];
    auto own = B.middleRows(offsets_[node.columns.begin], node.width);
    const auto L = panel(node);
    Eigen::MatrixXd below(node.below(), B.cols());
    Eigen::Index taken = 0;
    for (const Index block : tree_.rows_of(node)) {
      const auto row = static_cast<std::size_t>(block);
      const Eigen::Index rows = offsets_[row + 1] - offsets_[row];
      below.middleRows(taken, rows) = B.middleRows(offsets_[row], rows);
      taken += rows;
    }
    own.noalias() -= L.bottomRows(node.below()).transpose() * below;
    L.topRows(node.width).triangularView<Lower>().transpose().solveInPlace(own);
  });
  return B;
}

Supernodes SparseCholesky::supernodes() const {
  Supernodes factor;
  factor.reserve(tree_.nodes.size());
  for (const FactorNode& node : tree_.nodes) {
    Supernode& L = factor.emplace_back();
    L.begin = offsets_[node.columns.begin];
    L.end = L.begin + node.width;
    L.values = values_.get() + node.first_value;
    for (auto row = L.begin; row < L.end; ++row) L.rows.push_back(row);
    for (const Index below : tree_.rows_of(node)) {
      const auto block = static_cast<std::size_t>(below);
      for (auto row = offsets_[block]; row < offsets_[block + 1]; ++row) L.rows.push_back(row);
    }
  }
  return factor;
}

}  // namespace mapjoin
