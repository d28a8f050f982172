// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/spanning_tree.hpp>
#include <mapjoin/join/study/convexity_objective.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/linearise.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// The linearity of rows, by the relations that are coordinates of the state: the pose that each pose and feature is measured
/// from, and the direction.
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

  /// True if all rows of a pose seen from `base` are linear.
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

  /// True if the relation of `child` is with `parent`, measured from the child or from the parent as `from_child` says.
  /// Constant poses are interchangeable as parents.
  bool hangs(PoseIndex child, PoseIndex parent, bool from_child) const {
    if (is_still(child)) return is_still(parent);
    const auto& edge = poses_[child];
    if ((edge->observation && edge->observation->child_is_base) != from_child) return false;
    return edge->parent == parent || (!from_child && is_still(edge->parent) && is_still(parent));
  }

  const JoiningSystem<Dim>& system_;
  JoinedState state_;
  Table<PoseIndex, std::optional<TreeEdge<PoseIndex>>> poses_;  // by place; nullopt if anchored
  Table<FeatureIndex, TreeEdge<FeatureIndex>> features_;
};

/// The rows of one observation or map: their Jacobian over its free variables, and the linear ones among them.
template <int Dim>
struct Rows {
  static constexpr int kDof = kPoseDof<Dim>;

  std::vector<Variable> free;
  std::vector<Eigen::Index> begin;  // first column of each variable, the base first; -1 if it is constant
  std::size_t targets = 0;          // number of targets whose rows have been added
  Eigen::MatrixXd J;
  std::vector<Eigen::Index> linear;
  std::vector<Eigen::Index> other;

  Rows(const NormalEquations& equations, const IntegratedObservation<Dim>& o) {
    Eigen::Index columns = 0;
    for (const Variable v : equations.pattern().factors[o.factor]) {
      begin.push_back(v == kConstant ? -1 : columns);
      if (v == kConstant) continue;
      free.push_back(v);
      columns += equations.dof(v);
    }
    J.setZero(o.W.rows(), columns);
  }
  /// Adds the rows of the next target. In the plane the row of its heading is linear in any case.
  template <int Dof>
  void add(const LinearTarget<Dim, Dof>& target, bool is_linear) {
    const Eigen::Index own = begin[++targets];
    auto row = static_cast<Eigen::Index>(linear.size() + other.size());
    if (begin[0] >= 0) J.block<Dof, kDof>(row, begin[0]) = target.J_base;
    if (own >= 0) J.block<Dof, Dof>(row, own) = target.J_target;
    for (int i = 0; i < Dof; ++i) (is_linear || (Dim == 2 && i == Dim) ? linear : other).push_back(row++);
  }
};

template <int Dim>
Rows<Dim> rows_of(const IntegratedObservation<Dim>& o, const JoiningSystem<Dim>& system, const Linearity<Dim>& linearity) {
  const Values<Dim>& at = system.estimate();
  const Pose<Dim> base = at.pose(o.base);
  Rows<Dim> rows(system.equations(), o);
  for (std::size_t p = 0; p < o.poses.size(); ++p) {
    rows.add(linearise<Dim>(o.measured_poses[p], base, at.pose(o.poses[p])), linearity.of_pose(o.base, o.poses[p]));
  }
  for (std::size_t f = 0; f < o.features.size(); ++f) {
    rows.add(linearise<Dim>(o.measured_features[f], base, at.features[o.features[f]]),
             linearity.of_feature(o.base, o.features[f]));
  }
  return rows;
}

}  // namespace

template <int Dim>
QuadraticShare quadratic_share(const JoiningSystem<Dim>& system, JoinedState state) {
  const Linearity<Dim> linearity(system, state);
  const Marginals marginals(system.equations());
  QuadraticShare share;
  for_each_integrated(system, [&](const IntegratedObservation<Dim>& o) {
    const Rows<Dim> rows = rows_of(o, system, linearity);
    share.rows += information_rank(Eigen::MatrixXd(o.W));
    if (rows.linear.empty()) return;
    const Eigen::MatrixXd M = marginal_information(o.W, rows.linear, rows.other);
    share.quadratic_rows += information_rank(M);
    if (rows.free.empty()) return;
    const Eigen::MatrixXd J = rows.J(rows.linear, Eigen::all);
    share.information += (M * J * marginals.joint(rows.free)).cwiseProduct(J).sum();
  });
  if (const Eigen::Index size = system.equations().size(); size > 0) share.information /= static_cast<double>(size);
  return share;
}

template QuadraticShare quadratic_share(const JoiningSystem<2>&, JoinedState);
template QuadraticShare quadratic_share(const JoiningSystem<3>&, JoinedState);

}  // namespace mapjoin
