// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <limits>
#include <mapjoin/solve/engines/supernodal_tree.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// Columns of L with the same rows below them, without any zeros.
struct Columns {
  IndexRange<Column> columns;
  Column parent;  ///< The first row below; the number of columns for a root.
  Slice rows;     ///< Below them, in FundamentalSupernodes::rows.
};

/// The columns of L, from left to right, in runs of the same rows.
struct FundamentalSupernodes {
  std::vector<Columns> supernodes;
  std::vector<Column> rows;
};

/// The runs of columns that are a supernode each: a column goes on with the one before it if that is its child and has no other
/// rows. The border is one run.
std::vector<Columns> runs_of_columns(const EliminationTree& tree, Column border) {
  const Column end(tree.parent.size());
  std::vector<Columns> runs;
  for (const Column k : indices(tree.parent)) {
    const bool is_child_before = k > 0 && tree.parent[k - 1] == k && tree.counts[k - 1] == tree.counts[k] + 1;
    const bool goes_on = k < border ? is_child_before : k > border;
    if (!goes_on) runs.push_back({{k, k}, 0, {}});
    runs.back().columns.last = k + 1;
    runs.back().parent = k < border ? tree.parent[k] : end;
  }
  return runs;
}

/// The rows below each run: those of the matrix in its columns, and those of its children.
FundamentalSupernodes fundamental_supernodes(const BlockLower& A, Column border) {
  FundamentalSupernodes result{runs_of_columns(elimination_tree(A), border), {}};
  constexpr std::int32_t kNone = -1;
  Table<Column, std::int32_t> first_child(A.rows.size() + 1, kNone);  // the last one for roots
  std::vector<std::int32_t> next_child;
  Table<Column, std::int32_t> seen(A.rows.size(), kNone);  // per row, the last supernode that has it
  for (Columns& node : result.supernodes) {
    const auto s = static_cast<std::int32_t>(next_child.size());
    node.rows.begin = result.rows.size();
    const auto take = [&](Column row) {
      if (row >= node.columns.last && std::exchange(seen[row], s) != s) result.rows.push_back(row);
    };
    for (const Column k : node.columns) {
      for (const Column row : A.rows[k]) take(row);
      for (std::int32_t c = first_child[k]; c != kNone; c = next_child[static_cast<std::size_t>(c)]) {
        const Slice below = result.supernodes[static_cast<std::size_t>(c)].rows;
        for (std::size_t r = below.begin; r < below.end; ++r) take(result.rows[r]);
      }
    }
    node.rows.end = result.rows.size();
    std::sort(result.rows.begin() + static_cast<std::ptrdiff_t>(node.rows.begin), result.rows.end());
    next_child.push_back(std::exchange(first_child[node.parent], s));
  }
  return result;
}

/// The share of zeros that a supernode of up to `width` scalar columns may have.
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
  double entries = 0.0;  ///< Entries of L, without the zeros.

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
  group.width = A.offsets[supernode.columns.last] - A.offsets[supernode.columns.first];
  for (const Column row : supernode.rows.of(of.rows)) group.below += A.dof(row);
  group.entries = Group::entries_of(group.width, group.below);
  return group;
}

/// Merges supernodes that are hardly larger than their children with the last of these: fewer and wider panels.
std::vector<Group> relaxed(const FundamentalSupernodes& fundamental, const BlockLower& A, Column border) {
  std::vector<Group> groups;  // from the last to the first
  for (auto supernode = fundamental.supernodes.rbegin(); supernode != fundamental.supernodes.rend(); ++supernode) {
    const Group group = group_of(*supernode, fundamental, A);
    const bool depends = !groups.empty() && supernode->parent < groups.back().columns.columns.last;
    if (depends && supernode->parent < border && should_merge(group, groups.back())) {
      groups.back().columns.columns.first = group.columns.columns.first;
      groups.back().width += group.width;
      groups.back().entries += group.entries;
    } else {
      groups.push_back(group);
    }
  }
  std::reverse(groups.begin(), groups.end());
  return groups;
}

/// Appends a node of some columns and the rows below them.
FactorNode& append_node(SupernodalTree& tree, IndexRange<Column> columns, std::span<const Column> rows, const BlockLower& A) {
  FactorNode& node = tree.nodes.emplace_back();
  node.columns = columns;
  node.width = A.offsets[columns.last] - A.offsets[columns.first];
  node.height = node.width;
  for (const Column row : rows) node.height += A.dof(row);
  node.first_value = tree.value_count;
  tree.value_count += node.width * node.height;
  node.rows.begin = tree.rows.size();
  tree.rows.insert(tree.rows.end(), rows.begin(), rows.end());
  node.rows.end = tree.rows.size();
  return node;
}

/// Lays out nodes with their rows and panels; given fronts stand before the node that has the first of their rows.
void lay_out_nodes(SupernodalTree& tree, const std::vector<Group>& groups, const std::vector<Column>& rows,
                   std::span<const std::span<const Column>> given, const BlockLower& A) {
  std::vector<std::size_t> by_first_row(given.size());
  std::iota(by_first_row.begin(), by_first_row.end(), std::size_t{0});
  std::stable_sort(by_first_row.begin(), by_first_row.end(),
                   [&](std::size_t a, std::size_t b) { return given[a].front() < given[b].front(); });
  auto next = by_first_row.begin();
  for (const Group& group : groups) {
    const IndexRange<Column> columns = group.columns.columns;
    for (; next != by_first_row.end(); ++next) {
      const Column first = given[*next].front();
      if (first >= columns.last) break;
      append_node(tree, {first, first}, given[*next], A).given = *next;
    }
    append_node(tree, columns, group.columns.rows.of(rows), A);
  }
}

void find_parents(SupernodalTree& tree, std::size_t columns) {
  Table<Column, std::size_t> node_of(columns);
  for (std::size_t s = 0; s < tree.nodes.size(); ++s) {
    for (const Column k : tree.nodes[s].columns) node_of[k] = s;
  }
  for (FactorNode& node : tree.nodes) {
    const auto rows = tree.rows_of(node);
    node.parent = rows.empty() ? tree.nodes.size() : node_of[rows.front()];
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

/// Appends the rows below a supernode as runs, each of rows next to each other in the parent's front.
void append_runs(SupernodalTree& tree, FactorNode& node, const BlockLower& A, const Table<Column, std::int32_t>& front_row) {
  node.runs.begin = tree.runs.size();
  RowRun run;
  for (const Column row : tree.rows_of(node)) {
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

/// Finds the places of the entries of the matrix and of the rows of the children in each front.
void lay_out_fronts(SupernodalTree& tree, const BlockLower& A) {
  tree.front_rows.resize(A.rows.entries().size());
  Table<Column, std::int32_t> front_row(A.rows.size());
  for (const FactorNode& node : tree.nodes) {
    Eigen::Index height = 0;
    const auto place = [&](Column row) {
      front_row[row] = static_cast<std::int32_t>(height);
      height += A.dof(row);
    };
    for (const Column k : node.columns) place(k);
    for (const Column row : tree.rows_of(node)) place(row);

    for (const Column k : node.columns) {
      auto entry = A.rows.first(k);
      for (const Column row : A.rows[k]) tree.front_rows[entry++] = front_row[row];
    }
    for (const std::size_t child : tree.children_of(node)) append_runs(tree, tree.nodes[child], A, front_row);
  }
}

}  // namespace

SupernodalTree supernodal_tree(const BlockLower& matrix, std::span<const std::span<const Column>> given, std::size_t border) {
  SupernodalTree tree;
  tree.border = Column(matrix.rows.size() - border);
  const FundamentalSupernodes fundamental = fundamental_supernodes(matrix, tree.border);
  lay_out_nodes(tree, relaxed(fundamental, matrix, tree.border), fundamental.rows, given, matrix);
  find_parents(tree, matrix.rows.size());
  find_children(tree);
  lay_out_fronts(tree, matrix);
  tree.tasks = factor_tasks(tree);
  return tree;
}

}  // namespace mapjoin
