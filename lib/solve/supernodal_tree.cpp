// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <limits>
#include <mapjoin/solve/factor_tasks.hpp>
#include <mapjoin/solve/supernodal_tree.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Columns of L with the same rows below them, without any zeros.
struct Columns {
  Slice columns;
  Slice rows;  ///< Below them, in FundamentalSupernodes::rows.
};

/// The columns of L, from left to right: those of one supernode go on as long as they bring no new rows.
class FundamentalSupernodes {
 public:
  explicit FundamentalSupernodes(const BlockLower& A) : A_(A), first_child_(A.blocks(), kNone), seen_(A.blocks(), kNone) {
    for (std::size_t k = 0; k < A.blocks(); ++k) add_column(k);
  }

  std::vector<Columns> supernodes;
  std::vector<Index> rows;

  /// The first row below a supernode, whose column depends on it; the number of columns for a root.
  std::size_t first_row(const Columns& node) const {
    return node.rows.size() == 0 ? A_.blocks() : static_cast<std::size_t>(rows[node.rows.begin]);
  }

 private:
  static constexpr std::int32_t kNone = -1;

  void add_column(std::size_t k) {
    const bool is_next = !supernodes.empty() && first_row(supernodes.back()) == k;
    if (!supernodes.empty() && !is_next) attach(supernodes.size() - 1);
    const auto last = static_cast<std::int32_t>(supernodes.size()) - 1;
    bool goes_on = is_next;
    for_each_row(k, [&](Index row) { goes_on = goes_on && seen_[static_cast<std::size_t>(row)] == last; });
    if (goes_on) {
      ++supernodes.back().columns.end;
      ++supernodes.back().rows.begin;
      return;
    }
    if (is_next) attach(supernodes.size() - 1);
    const std::size_t begin = rows.size();
    for_each_row(k, [&](Index row) {
      if (std::exchange(seen_[static_cast<std::size_t>(row)], last + 1) != last + 1) rows.push_back(row);
    });
    std::sort(rows.begin() + static_cast<std::ptrdiff_t>(begin), rows.end());
    supernodes.push_back({{k, k + 1}, {begin, rows.size()}});
    next_child_.push_back(kNone);
  }

  void attach(std::size_t node) {
    const std::size_t parent = first_row(supernodes[node]);
    if (parent < A_.blocks()) next_child_[node] = std::exchange(first_child_[parent], static_cast<std::int32_t>(node));
  }
  /// Calls f for the rows below the diagonal of column k of the matrix, and of the supernodes attached to it.
  template <typename F>
  void for_each_row(std::size_t k, F&& f) const {
    for (const Index row : A_.rows_of(k).subspan(1)) f(row);
    for (std::int32_t child = first_child_[k]; child != kNone; child = next_child_[static_cast<std::size_t>(child)]) {
      const Slice below = supernodes[static_cast<std::size_t>(child)].rows;
      for (std::size_t r = below.begin + 1; r < below.end; ++r) f(rows[r]);
    }
  }

  const BlockLower& A_;
  std::vector<std::int32_t> first_child_;  // per column
  std::vector<std::int32_t> next_child_;   // per supernode
  std::vector<std::int32_t> seen_;         // per row, the last supernode that has it
};

/// Up to `width` scalar columns, a supernode may have this share of zeros.
struct Relaxation {
  Eigen::Index width;
  double zeros;
};
constexpr std::array<Relaxation, 4> kRelaxations{
    {{4, 1.0}, {16, 0.8}, {48, 0.1}, {std::numeric_limits<Eigen::Index>::max(), 0.05}}};

/// Columns that will be one supernode, with the rows below the last of them.
struct Group {
  Columns columns;
  Eigen::Index width = 0;
  Eigen::Index below = 0;
  double entries = 0.0;  ///< Without the zeros.

  static double entries_of(Eigen::Index width, Eigen::Index below) {
    return static_cast<double>(width) * (static_cast<double>(width + 1) / 2.0 + static_cast<double>(below));
  }
};

bool should_merge(const Group& child, const Group& parent) {
  const Eigen::Index width = child.width + parent.width;
  const double zeros = 1.0 - (child.entries + parent.entries) / Group::entries_of(width, parent.below);
  const auto relaxation =
      std::find_if(kRelaxations.begin(), kRelaxations.end(), [&](const auto& r) { return width <= r.width; });
  return zeros <= relaxation->zeros;
}

Group group_of(const Columns& supernode, const FundamentalSupernodes& of, const BlockLower& A) {
  Group group{supernode};
  group.width = A.offsets[supernode.columns.end] - A.offsets[supernode.columns.begin];
  for (const Index row : supernode.rows.of(of.rows)) group.below += A.dof(static_cast<std::size_t>(row));
  group.entries = Group::entries_of(group.width, group.below);
  return group;
}

/// Supernodes that are hardly larger than their children become one with the last of these: fewer and wider panels.
std::vector<Group> relaxed(const FundamentalSupernodes& fundamental, const BlockLower& A) {
  std::vector<Group> groups;  // from the last to the first
  for (auto supernode = fundamental.supernodes.rbegin(); supernode != fundamental.supernodes.rend(); ++supernode) {
    const Group group = group_of(*supernode, fundamental, A);
    const bool depends = !groups.empty() && fundamental.first_row(*supernode) < groups.back().columns.columns.end;
    if (depends && should_merge(group, groups.back())) {
      groups.back().columns.columns.begin = group.columns.columns.begin;
      groups.back().width += group.width;
      groups.back().entries += group.entries;
    } else {
      groups.push_back(group);
    }
  }
  std::reverse(groups.begin(), groups.end());
  return groups;
}

/// Nodes with their rows and panels.
void lay_out_nodes(SupernodalTree& tree, const std::vector<Group>& groups, const std::vector<Index>& rows) {
  for (const Group& group : groups) {
    FactorNode node;
    node.columns = group.columns.columns;
    node.width = group.width;
    node.height = group.width + group.below;
    node.first_value = tree.value_count;
    tree.value_count += node.width * node.height;
    node.rows.begin = tree.rows.size();
    const auto below = group.columns.rows.of(rows);
    tree.rows.insert(tree.rows.end(), below.begin(), below.end());
    node.rows.end = tree.rows.size();
    tree.nodes.push_back(node);
  }
}

void find_parents(SupernodalTree& tree, std::size_t columns) {
  std::vector<std::size_t> node_of(columns);
  for (std::size_t s = 0; s < tree.nodes.size(); ++s) {
    for (std::size_t k = tree.nodes[s].columns.begin; k < tree.nodes[s].columns.end; ++k) node_of[k] = s;
  }
  for (FactorNode& node : tree.nodes) {
    const auto rows = tree.rows_of(node);
    node.parent = rows.empty() ? tree.nodes.size() : node_of[static_cast<std::size_t>(rows.front())];
  }
}

void find_children(SupernodalTree& tree) {
  std::vector<std::size_t> counts(tree.nodes.size() + 1, 0);
  for (const FactorNode& node : tree.nodes) ++counts[node.parent];
  std::size_t begin = 0;
  for (std::size_t s = 0; s < tree.nodes.size(); ++s) {
    tree.nodes[s].children = {begin, begin};
    begin += counts[s];
  }
  tree.children.resize(begin);
  for (std::size_t s = 0; s < tree.nodes.size(); ++s) {
    if (tree.nodes[s].parent < tree.nodes.size()) tree.children[tree.nodes[tree.nodes[s].parent].children.end++] = s;
  }
}

/// Rows below a supernode, in one run as far as they are next to each other in the parent's front.
void append_runs(SupernodalTree& tree, FactorNode& node, const BlockLower& A, const std::vector<std::int32_t>& front_row) {
  node.runs.begin = tree.runs.size();
  RowRun run;
  for (const Index block : tree.rows_of(node)) {
    const auto row = static_cast<std::size_t>(block);
    if (run.length > 0 && front_row[row] != run.to + run.length) {
      tree.runs.push_back(run);
      run = {run.from + run.length, 0, 0};
    }
    if (run.length == 0) run.to = front_row[row];
    run.length += static_cast<std::int32_t>(A.dof(row));
  }
  tree.runs.push_back(run);
  node.runs.end = tree.runs.size();
}

/// Where the entries of the matrix and the rows of the children lie in each front.
void lay_out_fronts(SupernodalTree& tree, const BlockLower& A) {
  tree.front_rows.resize(A.rows.size());
  std::vector<std::int32_t> front_row(A.blocks());
  for (const FactorNode& node : tree.nodes) {
    Eigen::Index height = 0;
    const auto place = [&](std::size_t row) {
      front_row[row] = static_cast<std::int32_t>(height);
      height += A.dof(row);
    };
    for (std::size_t k = node.columns.begin; k < node.columns.end; ++k) place(k);
    for (const Index row : tree.rows_of(node)) place(static_cast<std::size_t>(row));

    for (auto entry = A.begin[node.columns.begin]; entry < A.begin[node.columns.end]; ++entry) {
      const auto e = static_cast<std::size_t>(entry);
      tree.front_rows[e] = front_row[static_cast<std::size_t>(A.rows[e])];
    }
    for (const std::size_t child : tree.children_of(node)) append_runs(tree, tree.nodes[child], A, front_row);
  }
}

}  // namespace

SupernodalTree supernodal_tree(const BlockLower& matrix) {
  SupernodalTree tree;
  const FundamentalSupernodes fundamental(matrix);
  lay_out_nodes(tree, relaxed(fundamental, matrix), fundamental.rows);
  find_parents(tree, matrix.blocks());
  find_children(tree);
  lay_out_fronts(tree, matrix);
  tree.tasks = factor_tasks(tree);
  return tree;
}

}  // namespace mapjoin
