// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <mapjoin/join/join.hpp>
#include <mapjoin/join/join_problem.hpp>
#include <mapjoin/join/placement.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Rows of an information matrix that were measured.
template <typename Derived>
std::int64_t measured_rows(const Eigen::MatrixBase<Derived>& information) {
  return (information.diagonal().array() > 0.0).count();
}

template <int Dim>
std::int64_t measured_rows(const Piece<Dim>& piece, const Gauge<Dim>& gauge) {
  std::int64_t rows = 0;
  for (const auto* map : piece.maps) rows += measured_rows(map->information);
  for (const auto* list : {&piece.pose_observations, &gauge.pose_priors}) {
    for (const auto* o : *list) rows += measured_rows(o->information);
  }
  for (const auto* list : {&piece.feature_observations, &gauge.feature_priors}) {
    for (const auto* o : *list) rows += measured_rows(o->information);
  }
  return rows;
}

template <int Dim>
void take_values(const State<Dim>& state, Piece<Dim>& piece) {
  for (std::size_t p = 0; p < piece.poses.size(); ++p) piece.state.poses[p] = state.pose(piece.poses[p]);
  for (std::size_t f = 0; f < piece.features.size(); ++f) piece.state.features[f] = state.feature(piece.features[f]);
}

/// Pieces that only the World ties together, each in its frame.
template <int Dim>
std::pair<Piece<Dim>, Gauge<Dim>> settle_all(const Network<Dim>& network, const Pose<Dim>& origin, JoinedPieces<Dim> joined) {
  Piece<Dim> whole = std::move(joined.pieces.front());
  Gauge<Dim> gauge = settle_in_world(network, origin, whole);
  for (std::size_t k = 1; k < joined.pieces.size(); ++k) {
    settle_in_world(network, origin, joined.pieces[k]);
    whole = merged(whole, joined.pieces[k], Pose<Dim>{});
  }
  if (joined.pieces.size() > 1) gauge = settle_in_world(network, origin, whole);
  for (const auto* closure : joined.pending) whole.pose_observations.push_back(closure);
  // Pieces that met late are out of order; the maps are members of one vector, so that addresses give the network's order.
  std::sort(whole.maps.begin(), whole.maps.end(), std::less<>());
  return {std::move(whole), std::move(gauge)};
}

tl::unexpected<Error> interrupted() {
  return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted while joining"});
}

}  // namespace

template <int Dim>
Expected<Join<Dim>> join(const Network<Dim>& network, const std::vector<PoseId>& pose_ids,
                         const std::vector<FeatureId>& feature_ids, const JoinOptions<Dim>& options,
                         const std::stop_token& stop) {
  const Schedule order = options.start ? Schedule::kBatch : options.schedule;
  const ScheduleOptions schedule{order, ScheduleOptions::leading(order), options.progress};
  JoinedPieces<Dim> joined = join_stretches(network, schedule, stop);
  if (options.start) {
    for (auto& piece : joined.pieces) take_values(*options.start, piece);
  }
  auto [whole, gauge] = settle_all(network, options.origin, std::move(joined));
  if (stop.stop_requested()) return interrupted();

  Join<Dim> join;
  JoinProblem<Dim> problem(whole, gauge);
  join.result = minimise(problem, options.solver, stop);
  if (join.result.status == MinimiseStatus::kInterrupted) return interrupted();
  if (join.result.status == MinimiseStatus::kSingular) {
    const auto place = static_cast<std::size_t>(problem.system().place_of_variable(*join.result.singular));
    const bool is_pose = place < whole.poses.size();
    const std::string name = is_pose
                                 ? to_string(pose_ids[static_cast<std::size_t>(whole.poses[place])])
                                 : to_string(feature_ids[static_cast<std::size_t>(whole.features[place - whole.poses.size()])]);
    return bad_input(fmt::format("{} cannot be determined: the observations leave it free to move", name));
  }
  join.state.poses.resize(network.pose_count);
  join.state.features.resize(network.feature_count, Point<Dim>::Zero());
  for (std::size_t p = 0; p < whole.poses.size(); ++p) {
    join.state.poses[static_cast<std::size_t>(whole.poses[p])] = problem.estimate().poses[p];
  }
  for (std::size_t f = 0; f < whole.features.size(); ++f) {
    join.state.features[static_cast<std::size_t>(whole.features[f])] = problem.estimate().features[f];
  }
  for (const auto& condensed : network.maps) recover_private_features(condensed, join.state);
  for (const Index place : gauge.held) join.held.push_back(whole.poses[static_cast<std::size_t>(place)]);
  join.rows = measured_rows(whole, gauge);
  join.poses = std::move(whole.poses);
  join.features = std::move(whole.features);
  join.system = std::make_unique<JointSystem<Dim>>(std::move(problem.system()));
  return join;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                    \
  template Expected<Join<Dim>> join(const Network<Dim>&, const std::vector<PoseId>&, const std::vector<FeatureId>&, \
                                    const JoinOptions<Dim>&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
