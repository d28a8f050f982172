// SPDX-License-Identifier: BSD-3-Clause
// Distribution of a factorisation, and of the solves with it, over threads.

#include <algorithm>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/engines/supernodal_tree.hpp>
#include <span>
#include <utility>

namespace mapjoin {
namespace {

/// The least share of all work in a task.
constexpr double kLeastShare = 1.0 / 32.0;
/// The least number of multiplications in a task: some tenths of a millisecond.
constexpr double kLeastWork = 5e5;

class TaskCutter {
 public:
  explicit TaskCutter(const SupernodalTree& tree) : tree_(tree), work_(tree.nodes.size() + 1, 0.0) {
    for (std::size_t s = 0; s < tree.nodes.size(); ++s) {
      const auto height = static_cast<double>(tree.nodes[s].height);
      if (!tree.is_border(tree.nodes[s])) work_[s] += static_cast<double>(tree.nodes[s].width) * height * height;
      work_[tree.nodes[s].parent] += work_[s];
    }
    least_ = std::max(kLeastShare * work_.back(), kLeastWork);
  }

  FactorTask whole() {
    FactorTask task;
    std::vector<std::size_t> roots;
    for (std::size_t s = 0; s < tree_.nodes.size(); ++s) {
      if (tree_.nodes[s].parent == tree_.nodes.size()) roots.push_back(s);
    }
    cut(task, roots);
    return task;
  }

 private:
  /// Shares out the subtrees of `roots`, on which the nodes of the task depend. If only one of them is worth a task of its own,
  /// its root becomes part of this one, and so on downwards.
  void cut(FactorTask& task, std::span<const std::size_t> roots) {
    while (true) {
      std::vector<std::size_t> large;
      FactorTask bundle;
      double bundled = 0.0;
      for (const std::size_t root : roots) {
        if (work_[root] >= least_) {
          large.push_back(root);
          continue;
        }
        append_subtree(bundle.nodes, root);
        bundled += work_[root];
        if (bundled < least_) continue;
        task.before.push_back(std::exchange(bundle, {}));
        bundled = 0.0;
      }
      task.nodes.insert(task.nodes.end(), bundle.nodes.begin(), bundle.nodes.end());
      if (large.size() != 1 || !task.before.empty()) {
        for (const std::size_t root : large) task.before.push_back(rooted(root));
        break;
      }
      task.nodes.push_back(large.front());
      roots = tree_.children_of(tree_.nodes[large.front()]);
    }
  }

  FactorTask rooted(std::size_t root) {
    FactorTask task;
    task.nodes.push_back(root);
    cut(task, tree_.children_of(tree_.nodes[root]));
    return task;
  }

  void append_subtree(std::vector<std::size_t>& nodes, std::size_t root) const {
    std::size_t next = nodes.size();
    nodes.push_back(root);
    for (; next < nodes.size(); ++next) {
      const auto children = tree_.children_of(tree_.nodes[nodes[next]]);
      nodes.insert(nodes.end(), children.begin(), children.end());
    }
  }

  const SupernodalTree& tree_;
  std::vector<double> work_;  // work of each subtree, and of all
  double least_ = 0.0;
};

void sort_nodes(FactorTask& task) {
  std::sort(task.nodes.begin(), task.nodes.end());
  for (FactorTask& other : task.before) sort_nodes(other);
}

}  // namespace

FactorTask factor_tasks(const SupernodalTree& tree) {
  FactorTask tasks = TaskCutter(tree).whole();
  sort_nodes(tasks);
  return tasks;
}

void for_each_upwards(const FactorTask& tasks, const std::function<void(std::size_t)>& f) {
  parallel_for(tasks.before.size(), [&](std::size_t k) { for_each_upwards(tasks.before[k], f); });
  for (const std::size_t node : tasks.nodes) f(node);
}

void for_each_downwards(const FactorTask& tasks, const std::function<void(std::size_t)>& f) {
  for (auto node = tasks.nodes.rbegin(); node != tasks.nodes.rend(); ++node) f(*node);
  parallel_for(tasks.before.size(), [&](std::size_t k) { for_each_downwards(tasks.before[k], f); });
}

}  // namespace mapjoin
