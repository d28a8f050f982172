// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <mapjoin/join/map_covariances.hpp>
#include <mapjoin/parallel/parallel_try.hpp>
#include <mapjoin/solve/memory.hpp>
#include <mutex>
#include <thread>

namespace mapjoin {
namespace {

template <typename Expression>
auto symmetric(const Expression& expression) {
  const auto M = expression.eval();
  return (0.5 * (M + M.transpose())).eval();
}

tl::unexpected<Error> interrupted() {
  return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted while computing covariances"});
}

}  // namespace

template <int Dim>
Eigen::MatrixXd MapCovariances<Dim>::joined_covariance(std::span<const Index> slots, const Marginals& marginals) const {
  std::vector<Index> free;
  std::vector<Eigen::Index> rows;
  Eigen::Index size = 0;
  for (const Index v : slots) {
    const int dof = v == kConstant ? kPoseDof<Dim> : equations().dof(v);  // only poses are held
    for (int i = 0; v != kConstant && i < dof; ++i) rows.push_back(size + i);
    if (v != kConstant) free.push_back(v);
    size += dof;
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  covariance(rows, rows) = marginals.joint(free);
  return covariance;
}

/// A variable and its parent in the tree are in one clique.
template <int Dim>
void MapCovariances<Dim>::add_joined(const Marginals& marginals, MarginalCovariances<Dim>& out) const {
  const auto add = [&](const Home& child, auto& relation, const auto& J, auto& covariance) {
    const Index parent = relation.parent == kWorld ? kConstant : home(PoseOrFeature::pose(relation.parent)).variable;
    const Eigen::MatrixXd joint = joined_covariance(std::array{parent, child.variable}, marginals);
    covariance = joint.bottomRightCorner(covariance.rows(), covariance.cols());
    relation.covariance = symmetric(J * joint * J.transpose());
  };
  for (std::size_t p = 0; p < pose_homes_.size(); ++p) {
    auto& relation = out.relations.poses[p];
    if (pose_homes_[p].variable == kConstant) continue;
    add(pose_homes_[p], relation, J_relation(state_.pose(relation.parent), state_.poses[p]), out.poses[p]);
  }
  for (std::size_t f = 0; f < feature_homes_.size(); ++f) {
    auto& relation = out.relations.features[f];
    if (feature_homes_[f].variable == kConstant) continue;
    add(feature_homes_[f], relation, J_relation<Dim>(state_.pose(relation.parent), state_.features[f]), out.features[f]);
  }
}

template <int Dim>
typename MapCovariances<Dim>::OwnParent MapCovariances<Dim>::parent_of(const OwnGivenShared<Dim>& own, std::size_t map,
                                                                       Eigen::Index k) const {
  if (!own.is_pose(k)) return {-1, 0};  // the start of the map
  const LocalMap<Dim>& local = network_.maps[map].map;
  const Index before = own.poses[static_cast<std::size_t>(k)] - 1;
  if (before == local.base) return {-1, 0};
  const auto kept = std::lower_bound(local.poses.begin(), local.poses.end(), before);
  if (kept == local.poses.end() || *kept != before) return {k - 1, -1};
  return {-1, (1 + (kept - local.poses.begin())) * kPoseDof<Dim>};
}

template <int Dim>
Expected<void> MapCovariances<Dim>::add_own(std::size_t map, const Marginals& marginals, MarginalCovariances<Dim>& out) const {
  if (own_poses(map) + own_features(map) == 0) return {};
  const auto own = own_of(map);
  if (!own) return tl::unexpected(own.error());
  const Eigen::MatrixXd shared = joined_covariance(join_.system->map_variables(map), marginals);
  const auto add = [&](Eigen::Index k, const Eigen::MatrixXd& J, auto& relation, auto& covariance) {
    const auto A = own->gain.middleRows(own->row(k), own->dof(k));
    const Eigen::MatrixXd Q = own->covariance({&k, 1});
    covariance = symmetric(Q + A * shared * A.transpose());
    // J (δ_parent, δ_k) = G δ_shared + e.
    const auto J_parent = J.leftCols<kPoseDof<Dim>>();
    const auto J_child = J.rightCols(own->dof(k));
    const OwnParent parent = parent_of(*own, map, k);
    Eigen::MatrixXd G = J_child * A;
    Eigen::MatrixXd cov_e;
    if (parent.own < 0) {
      G.middleCols<kPoseDof<Dim>>(parent.column) += J_parent;
      cov_e = J_child * Q * J_child.transpose();
    } else {
      G += J_parent * own->gain.template middleRows<kPoseDof<Dim>>(own->row(parent.own));
      cov_e = J * own->covariance(std::array{parent.own, k}) * J.transpose();
    }
    relation.covariance = symmetric(cov_e + G * shared * G.transpose());
  };
  for (std::size_t k = 0; k < own->poses.size(); ++k) {
    const auto pose = static_cast<std::size_t>(own->poses[k]);
    auto& relation = out.relations.poses[pose];
    add(static_cast<Eigen::Index>(k), J_relation(state_.pose(relation.parent), state_.poses[pose]), relation, out.poses[pose]);
  }
  for (std::size_t k = 0; k < own->features.size(); ++k) {
    const auto feature = static_cast<std::size_t>(own->features[k]);
    auto& relation = out.relations.features[feature];
    add(static_cast<Eigen::Index>(own->poses.size() + k),
        J_relation<Dim>(state_.pose(relation.parent), state_.features[feature]), relation, out.features[feature]);
  }
  return {};
}

template <int Dim>
std::int64_t MapCovariances<Dim>::marginal_bytes() const {
  std::int64_t largest_map = 0;
  for (std::size_t m = 0; m < network_.maps.size(); ++m) {
    const auto features = static_cast<std::int64_t>(own_features(m)) * Dim;
    const auto own = static_cast<std::int64_t>(own_poses(m)) * kPoseDof<Dim> + features;
    const std::int64_t border = network_.maps[m].map.information.rows() + kPoseDof<Dim> + features;
    // Chain and border before and after elimination, gains, and the covariance of what is shared.
    if (own > 0) largest_map = std::max(largest_map, 6 * (own + border) * border);
  }
  const auto poses = static_cast<std::int64_t>(network_.pose_count * (sizeof(PoseMatrix<Dim>) + sizeof(PoseRelation<Dim>)));
  const auto features =
      static_cast<std::int64_t>(network_.feature_count * (sizeof(PointMatrix<Dim>) + sizeof(FeatureRelation<Dim>)));
  return Marginals::bytes(equations()) + poses + features + 8 * largest_map * std::max(1U, std::thread::hardware_concurrency());
}

template <int Dim>
Expected<MarginalCovariances<Dim>> MapCovariances<Dim>::marginals(const std::function<void(std::size_t, std::size_t)>& progress,
                                                                  const std::stop_token& stop) const {
  if (auto fits = check_memory("the covariances of all poses and features", marginal_bytes(), most_memory_); !fits) {
    return tl::unexpected(fits.error());
  }
  const std::size_t nodes = equations().supernode_count();
  const std::size_t to_do = nodes + network_.maps.size();
  const auto go_on = [&](std::size_t done) {
    if (progress) progress(done, to_do);
    return !stop.stop_requested();
  };
  const Marginals marginals(equations(), go_on);
  if (stop.stop_requested()) return interrupted();
  MarginalCovariances<Dim> out{std::vector<PoseMatrix<Dim>>(network_.pose_count, PoseMatrix<Dim>::Zero()),
                               std::vector<PointMatrix<Dim>>(network_.feature_count),
                               relations_of(network_, join_, segments_, state_)};
  add_joined(marginals, out);
  std::mutex progress_mutex;
  std::size_t done = nodes;
  const auto added = parallel_try(network_.maps.size(), [&](std::size_t m) {
    if (stop.stop_requested()) return Expected<void>(interrupted());
    auto own = add_own(m, marginals, out);
    const std::lock_guard lock(progress_mutex);
    go_on(++done);
    return own;
  });
  if (stop.stop_requested()) return interrupted();
  return added.map([&] { return std::move(out); });
}

template Expected<MarginalCovariances<2>> MapCovariances<2>::marginals(const std::function<void(std::size_t, std::size_t)>&,
                                                                       const std::stop_token&) const;
template Expected<MarginalCovariances<3>> MapCovariances<3>::marginals(const std::function<void(std::size_t, std::size_t)>&,
                                                                       const std::stop_token&) const;

}  // namespace mapjoin
