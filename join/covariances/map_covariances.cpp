// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <mapjoin/join/covariances/map_covariances.hpp>
#include <mapjoin/solve/cross_covariances.hpp>
#include <mapjoin/solve/memory_limit.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <typename Expression>
auto symmetric(const Expression& expression) {
  const auto M = expression.eval();
  return (0.5 * (M + M.transpose())).eval();
}

}  // namespace

template <int Dim>
MapCovariances<Dim>::MapCovariances(Restored<Dim>& restored, Estimate estimate, std::int64_t most_memory)
    : equations_(std::move(restored.system.equations())),
      estimate_(estimate),
      most_memory_(most_memory),
      pose_variables_(restored.graph.pose_count, kConstant),
      feature_variables_(restored.graph.feature_count, kConstant),
      relations_(relations_of(restored)) {
  const PartialMap<Dim>& joined_map = restored.joined_map;
  const JoiningSystem<Dim>& system = restored.system;
  state_.poses.resize(pose_variables_.size());
  state_.features.resize(feature_variables_.size(), Point<Dim>::Zero());
  write_values(system.estimate(), joined_map.poses, joined_map.features, state_);
  for (const PoseIndex p : indices(joined_map.poses)) {
    const Variable variable = system.variable(p);
    pose_variables_[joined_map.poses[p]] = variable;
    if (variable == kConstant) anchored_.push_back(joined_map.poses[p]);
  }
  for (const FeatureIndex f : indices(joined_map.features)) {
    feature_variables_[joined_map.features[f]] = system.variable(f);
  }
}

template <int Dim>
Expected<MapCovariances<Dim>> MapCovariances<Dim>::make(Restored<Dim>& restored, Estimate estimate, std::int64_t most_memory) {
  restored.system.linearise();
  if (restored.system.factorise(0.0)) return bad_input("the covariances are not finite: something is free to move");
  return MapCovariances(restored, estimate, most_memory);
}

template <int Dim>
template <int ChildDof, typename Child>
Matrix<kPoseDof<Dim> + ChildDof> MapCovariances<Dim>::with_parent(PoseIndex parent, Child child,
                                                                  const Marginals& marginals) const {
  const Variable of_child = variable(child);
  const Variable of_parent = variable(parent);
  Matrix<kPoseDof<Dim> + ChildDof> covariance;
  if (of_parent != kConstant) {
    covariance = marginals.joint(std::array{of_parent, of_child});
  } else {
    covariance.setZero();
    covariance.template bottomRightCorner<ChildDof, ChildDof>() = marginals[of_child];
  }
  return covariance;
}

template <int Dim>
Expected<Marginals> MapCovariances<Dim>::on_pattern(const std::function<void(std::size_t, std::size_t)>& progress,
                                                    const std::stop_token& stop) const {
  const std::int64_t bytes =
      Marginals::bytes(equations_) +
      static_cast<std::int64_t>(pose_variables_.size() * (sizeof(PoseMatrix<Dim>) + sizeof(PoseRelation<Dim>)) +
                                feature_variables_.size() * (sizeof(PointMatrix<Dim>) + sizeof(FeatureRelation<Dim>)));
  if (auto fits = check_memory("the covariances of all poses and features", bytes, most_memory_); !fits) {
    return tl::unexpected(fits.error());
  }
  const std::size_t to_do = equations_.supernode_count();
  Marginals marginals(equations_, [&](std::size_t done) {
    if (progress) progress(done, to_do);
    return !stop.stop_requested();
  });
  if (stop.stop_requested()) return interrupted("computing covariances");
  return marginals;
}

template <int Dim>
MarginalCovariances<Dim> MapCovariances<Dim>::marginals(const Marginals& marginals) const {
  constexpr int kDof = kPoseDof<Dim>;
  MarginalCovariances<Dim> out{Table<PoseIndex, PoseMatrix<Dim>>(pose_variables_.size(), PoseMatrix<Dim>::Zero()),
                               Table<FeatureIndex, PointMatrix<Dim>>(feature_variables_.size(), PointMatrix<Dim>::Zero()),
                               relations_};
  for (const PoseIndex p : indices(out.poses)) {
    if (pose_variables_[p] == kConstant) continue;
    PoseRelation<Dim>& relation = out.relations.poses[p];
    const auto joint = with_parent<kDof>(relation.parent, p, marginals);
    out.poses[p] = joint.template bottomRightCorner<kDof, kDof>();
    relation.covariance = relative_pose(relation.parent, p, joint);
  }
  for (const FeatureIndex f : indices(out.features)) {
    if (feature_variables_[f] == kConstant) continue;
    FeatureRelation<Dim>& relation = out.relations.features[f];
    const auto joint = with_parent<Dim>(relation.parent, f, marginals);
    out.features[f] = joint.template bottomRightCorner<Dim, Dim>();
    relation.covariance = relative_feature(relation.parent, f, joint);
  }
  return out;
}

template <int Dim>
Expected<Eigen::MatrixXd> MapCovariances<Dim>::joint(std::span<const PoseOrFeature> variables) const {
  const auto is_missing = [&](const PoseOrFeature& asked) { return !std::visit([&](auto of) { return has(of); }, asked); };
  const auto missing = std::ranges::find_if(variables, is_missing);
  if (missing != variables.end()) {
    return bad_input(fmt::format("the map has no {} of index {}",
                                 std::holds_alternative<PoseIndex>(*missing) ? "pose" : "feature",
                                 std::visit([](auto of) { return of.value; }, *missing)));
  }
  std::vector<Variable> free;
  std::vector<Eigen::Index> places;  // entries of the free variables in the covariance
  Eigen::Index size = 0;
  for (const PoseOrFeature& asked : variables) {
    const Variable v = std::visit([&](auto of) { return variable(of); }, asked);
    const int dof = std::holds_alternative<PoseIndex>(asked) ? kPoseDof<Dim> : Dim;
    if (v != kConstant) {
      free.push_back(v);
      for (int i = 0; i < dof; ++i) places.push_back(size + i);
    }
    size += dof;
  }
  const std::string what = "the joint covariance of " + plural(variables.size(), "pose or feature", "poses and features");
  const CrossCovariances cross(equations_);
  return check_memory(what, cross.bytes(free), most_memory_).map([&] {
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
    covariance(places, places) = cross.joint(free);
    return covariance;
  });
}

template <int Dim>
Expected<PoseMatrix<Dim>> MapCovariances<Dim>::relative_pose(PoseIndex base, PoseIndex target) const {
  return joint(std::array<PoseOrFeature, 2>{base, target}).map([&](const Eigen::MatrixXd& both) {
    return relative_pose(base, target, both);
  });
}

template <int Dim>
Expected<PointMatrix<Dim>> MapCovariances<Dim>::relative_feature(PoseIndex base, FeatureIndex feature) const {
  return joint(std::array<PoseOrFeature, 2>{base, feature}).map([&](const Eigen::MatrixXd& both) {
    return relative_feature(base, feature, both);
  });
}

template <int Dim>
PoseMatrix<Dim> MapCovariances<Dim>::relative_pose(PoseIndex base, PoseIndex target,
                                                   const Matrix<2 * kPoseDof<Dim>>& of_both) const {
  if (base == target) return PoseMatrix<Dim>::Zero();  // exactly, without the rounding of the product
  const auto J = J_relation(state_.pose(base), state_.pose(target));
  return symmetric(J * of_both * J.transpose());
}

template <int Dim>
PointMatrix<Dim> MapCovariances<Dim>::relative_feature(PoseIndex base, FeatureIndex feature,
                                                       const Matrix<kPoseDof<Dim> + Dim>& of_both) const {
  const auto J = J_relation<Dim>(state_.pose(base), state_.features[feature]);
  return symmetric(J * of_both * J.transpose());
}

template class MapCovariances<2>;
template class MapCovariances<3>;

}  // namespace mapjoin
