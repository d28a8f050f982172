// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>
#include <mutex>
#include <utility>

namespace mapjoin {
namespace {

using Eigen::Lower;
using Stride = Eigen::OuterStride<>;

void set_aside(const FactorValues& values, const FactorNode& node) {
  values.set_aside(static_cast<std::size_t>(node.first_value), static_cast<std::size_t>(node.height * node.width));
}

SupernodalTree tree_of(const BlockLower& matrix, std::span<const GivenFront> given, std::size_t border) {
  std::vector<std::span<const Column>> rows;
  for (const GivenFront& front : given) rows.emplace_back(front.rows);
  return supernodal_tree(matrix, rows, border);
}

/// One factorisation, with the updates on their way from supernode to parent. L goes to `values`, and an update goes once its
/// parent has taken it; without `values` each front keeps a panel of its own and its update.
class Factorisation {
 public:
  Factorisation(const SupernodalTree& tree, const BlockLower& matrix, std::span<const GivenFront> given,
                const FactorValues* values)
      : tree_(tree),
        matrix_(matrix),
        given_(given),
        values_(values),
        panels_(values ? 0 : tree.nodes.size()),
        updates_(tree.nodes.size()) {}

  /// Factorises, and returns the singular columns.
  std::vector<std::int64_t> run() {
    for_each_upwards(tree_.tasks, [this](std::size_t s) { eliminate_node(s); });
    std::sort(singular_.begin(), singular_.end());
    return std::move(singular_);
  }
  std::vector<Eigen::MatrixXd> take_panels() { return std::move(panels_); }
  std::vector<Eigen::MatrixXd> take_updates() { return std::move(updates_); }

 private:
  void eliminate_node(std::size_t s) {
    const FactorNode& node = tree_.nodes[s];
    if (node.width == 0) return make_given(s);
    if (tree_.is_border(node)) return assemble_border(s);
    const FrontalMatrix front{new_panel(s), new_update(s)};
    take_entries(node, front.panel);
    Eigen::VectorXd diagonal = front.panel.diagonal();
    add_children(node, 0, front.panel);
    if (!given_.empty()) diagonal = front.panel.diagonal();  // the matrix alone holds a part of it
    note_singular(matrix_.offsets[node.columns.first], eliminate(front, diagonal));
    add_children(node, node.width, front.update);  // after the elimination, which overwrites the update
    free_children(node);
    if (!keeps_fronts()) set_aside(*values_, node);
  }

  void make_given(std::size_t s) {
    const GivenFront& front = given_[tree_.nodes[s].given];
    if (front.make) front.make(new_update(s));
  }

  DenseBlock new_panel(std::size_t s) {
    const FactorNode& node = tree_.nodes[s];
    if (keeps_fronts()) panels_[s].resize(node.height, node.width);
    double* const values = keeps_fronts() ? panels_[s].data() : values_->data() + node.first_value;
    return {values, node.height, node.width, Stride(node.height)};
  }

  DenseBlock new_update(std::size_t s) {
    const Eigen::Index size = tree_.nodes[s].below();
    updates_[s].resize(size, size);
    return {updates_[s].data(), size, size, Stride(size)};
  }

  /// Assembles the Schur complement in the place of the border's panel.
  void assemble_border(std::size_t s) {
    const FactorNode& node = tree_.nodes[s];
    const DenseBlock panel = new_panel(s);
    take_entries(node, panel);
    add_children(node, 0, panel);
    free_children(node);
  }

  bool keeps_fronts() const { return !values_; }

  /// Frees the updates that the node has taken; if fronts are kept, only those of given fronts, which the caller has.
  void free_children(const FactorNode& node) {
    for (const std::size_t c : tree_.children_of(node)) {
      const bool is_given = tree_.nodes[c].width == 0;
      if (is_given || !keeps_fronts()) updates_[c].resize(0, 0);
    }
  }

  /// The update of a front: given, made when its turn came, or computed.
  ConstDenseBlock update_of(std::size_t s) const {
    const FactorNode& node = tree_.nodes[s];
    if (node.width == 0 && !given_[node.given].make) return given_[node.given].update;
    return {updates_[s].data(), node.below(), node.below(), Stride(node.below())};
  }

  /// Adds the updates of the children, as far as they belong to a block that begins at row and column `begin` of the front.
  void add_children(const FactorNode& node, Eigen::Index begin, DenseBlock block) const {
    for (const std::size_t c : tree_.children_of(node)) {
      add_update(update_of(c), tree_.runs_of(tree_.nodes[c]), begin, block);
    }
  }

  /// Sets the panel to the entries that the matrix has there.
  void take_entries(const FactorNode& node, DenseBlock panel) const {
    panel.setZero();
    if (matrix_.values.empty()) return;
    Eigen::Index column = 0;
    for (const Column k : node.columns) {
      const double* from = matrix_.values.data() + matrix_.first_value[k];
      for (Eigen::Index j = 0; j < matrix_.dof(k); ++j, ++column) {
        const std::int32_t* front_row = tree_.front_rows.data() + matrix_.rows.first(k);
        for (const Column row : matrix_.rows[k]) {
          const Eigen::Index rows = matrix_.dof(row);
          std::copy_n(from, rows, panel.data() + *front_row++ + column * panel.outerStride());
          from += rows;
        }
      }
    }
  }

  void note_singular(Eigen::Index begin, const std::vector<Eigen::Index>& columns) {
    if (columns.empty()) return;
    const std::lock_guard lock(mutex_);
    for (const Eigen::Index column : columns) singular_.push_back(begin + column);
  }

  const SupernodalTree& tree_;
  const BlockLower& matrix_;
  std::span<const GivenFront> given_;
  const FactorValues* values_;
  std::vector<Eigen::MatrixXd> panels_;   ///< Per supernode, if fronts are kept.
  std::vector<Eigen::MatrixXd> updates_;  ///< Per supernode, until free_children().
  std::mutex mutex_;
  std::vector<std::int64_t> singular_;
};

}  // namespace

void SparseCholesky::analyse(const BlockLower& matrix, std::span<const GivenFront> given) {
  tree_ = tree_of(matrix, given, border_);
  offsets_ = matrix.offsets;
  values_ = {};
  singular_ = {};
}

void SparseCholesky::make_room() {
  if (values_.is_empty()) values_ = FactorValues(static_cast<std::size_t>(tree_.value_count), folder_);
}

std::vector<std::int64_t> SparseCholesky::factorise(const BlockLower& matrix, std::span<const GivenFront> given) {
  make_room();
  singular_ = Factorisation(tree_, matrix, given, &values_).run();
  return singular_;
}

ConstDenseBlock SparseCholesky::panel(const FactorNode& node) const {
  return {values_.data() + node.first_value, node.height, node.width, Stride(node.height)};
}

void SparseCholesky::solve_upwards(Eigen::MatrixXd& B) const {
  std::vector<Eigen::MatrixXd> updates(tree_.nodes.size());  // per supernode, the update of the rows below it
  for_each_upwards(tree_.tasks, [&](std::size_t s) {
    const FactorNode& node = tree_.nodes[s];
    auto own = B.middleRows(offsets_[node.columns.first], node.width);
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
    if (tree_.is_border(node)) return;
    const auto L = panel(node);
    L.topRows(node.width).triangularView<Lower>().solveInPlace(own);
    updates[s].noalias() -= L.bottomRows(node.below()) * own;
    set_aside(values_, node);
  });
}

void SparseCholesky::solve_downwards(Eigen::MatrixXd& B) const {
  for_each_downwards(tree_.tasks, [&](std::size_t s) {
    const FactorNode& node = tree_.nodes[s];
    if (tree_.is_border(node)) return;
    auto own = B.middleRows(offsets_[node.columns.first], node.width);
    const auto L = panel(node);
    Eigen::MatrixXd below(node.below(), B.cols());
    Eigen::Index taken = 0;
    for (const Column row : tree_.rows_of(node)) {
      const Eigen::Index rows = offsets_[row + 1] - offsets_[row];
      below.middleRows(taken, rows) = B.middleRows(offsets_[row], rows);
      taken += rows;
    }
    own.noalias() -= L.bottomRows(node.below()).transpose() * below;
    L.topRows(node.width).triangularView<Lower>().transpose().solveInPlace(own);
    set_aside(values_, node);
  });
}

Eigen::MatrixXd SparseCholesky::solve_columns(Eigen::MatrixXd B) const {
  solve_upwards(B);
  solve_downwards(B);
  return B;
}

Eigen::MatrixXd SparseCholesky::solve_lower(Eigen::MatrixXd B) const {
  solve_upwards(B);
  return B;
}

Eigen::MatrixXd SparseCholesky::solve_upper(Eigen::MatrixXd B) const {
  solve_downwards(B);
  return B;
}

ConstDenseBlock SparseCholesky::schur_complement() const {
  if (border_ == 0) return {nullptr, 0, 0, Stride(0)};
  return panel(tree_.nodes.back());
}

Eigen::MatrixXd SparseCholesky::null_space(std::size_t most) const {
  // A = L' L'ᵀ, where L' is L without its columns of the identity: if Lᵀ z is the unit vector of such a column, A z is zero.
  const std::size_t count = std::min(singular_.size(), most);
  Eigen::MatrixXd Z = Eigen::MatrixXd::Zero(offsets_.back(), static_cast<Eigen::Index>(count));
  for (std::size_t k = 0; k < count; ++k) Z(singular_[k], static_cast<Eigen::Index>(k)) = 1.0;
  if (count > 0) solve_downwards(Z);
  return Z;
}

std::size_t SparseCholesky::supernode_count() const {
  return static_cast<std::size_t>(
      std::count_if(tree_.nodes.begin(), tree_.nodes.end(), [&](const FactorNode& node) { return is_eliminated(node); }));
}

Supernode SparseCholesky::supernode_of(std::int64_t column) const {
  const auto is_before = [&](const FactorNode& node) { return offsets_[node.columns.last] <= column; };
  auto found = std::ranges::partition_point(tree_.nodes, is_before);
  while (found->width == 0) ++found;  // given fronts stand before the node that they go into
  const FactorNode& node = *found;
  Supernode L;
  L.begin = offsets_[node.columns.first];
  L.end = L.begin + node.width;
  L.values = values_.data() + node.first_value;
  L.rows.reserve(static_cast<std::size_t>(node.height));
  for (auto row = L.begin; row < L.end; ++row) L.rows.push_back(row);
  for (const Column block : tree_.rows_of(node)) {
    for (auto row = offsets_[block]; row < offsets_[block + 1]; ++row) L.rows.push_back(row);
  }
  return L;
}

EliminatedFronts eliminate_fronts(const BlockLower& matrix, std::span<const GivenFront> given) {
  EliminatedFronts fronts{tree_of(matrix, given, 0), {}, {}, {}};
  Factorisation factorisation(fronts.tree, matrix, given, nullptr);
  fronts.singular = factorisation.run();
  fronts.panels = factorisation.take_panels();
  fronts.updates = factorisation.take_updates();
  return fronts;
}

}  // namespace mapjoin
