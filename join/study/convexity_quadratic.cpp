// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/spanning_tree.hpp>
#include <mapjoin/join/study/convexity_objective.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/linearise.hpp>
#include <mapjoin/model/marginal_information.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// Which relations are coordinates of the state: from which pose each pose and feature is measured, and in which direction.
template <int Dim>
class Linearity {
 public:
  Linearity(const JoiningSystem<Dim>& system, JoinedState state) : system_(system), state_(state) {
    if (state == JoinedState::kAbsolute) return;
    SpanningTree tree = spanning_tree(system);
    poses_.resize(system.estimate().poses.size());
    for (const auto& edge : tree.poses) poses_[edge.child] = edge;
    features_ = std::move(tree.features);
  }

  /// Whether all rows of a pose seen from `base` are linear.
  bool of_pose(PoseIndex base, PoseIndex target) const {
    if (state_ == JoinedState::kAbsolute) return is_still(base);
    return hangs(target, base, false) || (base != kWorld && hangs(base, target, true));
  }
  bool of_feature(PoseIndex base, FeatureIndex feature) const {
    if (state_ == JoinedState::kAbsolute) return is_still(base);
    const PoseIndex parent = features_[feature].parent;
    return parent == base || (is_still(parent) && is_still(base));
  }

 private:
  bool is_still(PoseIndex pose) const { return system_.variable(pose) == kConstant; }

  /// Whether the relation of `child` is with `parent`, measured from the child or from the parent. From one still pose it is as
  /// linear as from another.
  bool hangs(PoseIndex child, PoseIndex parent, bool from_child) const {
    if (is_still(child)) return is_still(parent);
    const auto& edge = poses_[child];
    if ((edge->observation && edge->observation->child_is_base) != from_child) return false;
    return edge->parent == parent || (!from_child && is_still(edge->parent) && is_still(parent));
  }

  const JoiningSystem<Dim>& system_;
  JoinedState state_;
  Table<PoseIndex, std::optional<TreeEdge<PoseIndex>>> poses_;  // by place; none where held
  Table<FeatureIndex, TreeEdge<FeatureIndex>> features_;
};

/// One observation or map: the Jacobian of its rows with respect to its slots that are free, and which rows are linear.
struct Rows {
  Eigen::MatrixXd J;
  std::vector<Eigen::Index> linear;
  std::vector<Eigen::Index> other;

  Rows(Eigen::Index rows, Eigen::Index columns) : J(Eigen::MatrixXd::Zero(rows, columns)) {}
};

template <int Dim>
class Counter {
 public:
  Counter(const JoiningSystem<Dim>& system, JoinedState state)
      : system_(system), linearity_(system, state), marginals_(system.equations()) {}

  QuadraticShare plural() {
    for_each_integrated(system_, [&](const IntegratedObservation<Dim>& o) { add(o); });
    share_.information /= static_cast<double>(system_.equations().size());
    return share_;
  }

 private:
  static constexpr int kDof = kPoseDof<Dim>;

  /// The variables of a factor that are free, and where each slot's columns begin.
  struct Slots {
    Slots(const Counter& counter, std::size_t factor) {
      for (const Variable v : counter.system_.equations().pattern().factors[factor]) {
        begin.push_back(v == kConstant ? -1 : columns);
        if (v == kConstant) continue;
        free.push_back(v);
        columns += counter.system_.equations().dof(v);
      }
    }
    std::vector<Variable> free;
    std::vector<Eigen::Index> begin;
    Eigen::Index columns = 0;
  };

  template <int Dof>
  static void set(const LinearTarget<Dim, Dof>& linear, Eigen::Index row, const Slots& slots, std::size_t slot, Rows& rows) {
    if (slots.begin[0] >= 0) rows.J.block<Dof, kDof>(row, slots.begin[0]) = linear.J_base;
    if (slots.begin[slot] >= 0) rows.J.block<Dof, Dof>(row, slots.begin[slot]) = linear.J_target;
  }

  /// The rows of an observation; the base is its first slot.
  Rows rows_of(const IntegratedObservation<Dim>& o, const Slots& slots) const {
    const Values<Dim>& at = system_.estimate();
    Rows rows(o.W.rows(), slots.columns);
    Eigen::Index row = 0;
    std::size_t slot = 1;
    for (std::size_t p = 0; p < o.poses.size(); ++p, ++slot) {
      set<kDof>(linearise<Dim>(o.measured_poses[p], at.pose(o.base), at.pose(o.poses[p])), row, slots, slot, rows);
      const bool is_linear = linearity_.of_pose(o.base, o.poses[p]);
      for (int i = 0; i < kDof; ++i) (is_linear || (Dim == 2 && i == Dim) ? rows.linear : rows.other).push_back(row++);
    }
    for (std::size_t f = 0; f < o.features.size(); ++f, ++slot) {
      set<Dim>(linearise<Dim>(o.measured_features[f], at.pose(o.base), at.features[o.features[f]]), row, slots, slot, rows);
      const bool is_linear = linearity_.of_feature(o.base, o.features[f]);
      for (int i = 0; i < Dim; ++i) (is_linear ? rows.linear : rows.other).push_back(row++);
    }
    return rows;
  }

  void add(const IntegratedObservation<Dim>& o) {
    const Slots slots(*this, o.factor);
    const Rows rows = rows_of(o, slots);
    share_.rows += information_rank(Eigen::MatrixXd(o.W));
    if (rows.linear.empty()) return;
    const Eigen::MatrixXd M = marginal_information(o.W, rows.linear, rows.other);
    share_.quadratic_rows += information_rank(M);
    if (slots.free.empty()) return;
    const Eigen::MatrixXd J = rows.J(rows.linear, Eigen::all);
    share_.information += (M * J * marginals_.joint(slots.free)).cwiseProduct(J).sum();
  }

  const JoiningSystem<Dim>& system_;
  Linearity<Dim> linearity_;
  Marginals marginals_;
  QuadraticShare share_;
};

}  // namespace

template <int Dim>
QuadraticShare quadratic_share(const JoiningSystem<Dim>& system, JoinedState state) {
  return Counter<Dim>(system, state).plural();
}

template QuadraticShare quadratic_share(const JoiningSystem<2>&, JoinedState);
template QuadraticShare quadratic_share(const JoiningSystem<3>&, JoinedState);

}  // namespace mapjoin
