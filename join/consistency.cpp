// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/consistency.hpp>
#include <mapjoin/join/join_problem.hpp>
#include <mapjoin/join/start.hpp>
#include <mapjoin/join/whole.hpp>
#include <mapjoin/join/world.hpp>
#include <mapjoin/measure/chi_squared.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The network of the estimate with nothing eliminated: every observation of a polished map, or whole local maps.
template <int Dim>
Network<Dim> uneliminated(const MapCovariances<Dim>& covariances) {
  Network<Dim> network = covariances.network();
  if (covariances.estimate() == Estimate::kJoined) {
    for (auto& map : network.maps) map = {uncondensed(map), {}, {}, {}, {}};
    return network;
  }
  network.maps.clear();
  for (const Segment<Dim>& segment : covariances.segments()) {
    for (const auto& o : segment.odometry) network.pose_observations.push_back(&o);
    for (const auto& o : segment.observations) network.feature_observations.push_back(&o);
  }
  network.is_joined.assign(network.pose_count, true);
  return network;
}

/// What takes the frame of the truth into that of the map.
template <int Dim>
Expected<Pose<Dim>> frame_of(const MapCovariances<Dim>& covariances, const Truth<Dim>& truth) {
  if (covariances.held().size() != 1) return Pose<Dim>{};
  const Index held = covariances.held().front();
  const auto& true_pose = truth.poses[static_cast<std::size_t>(held)];
  if (!true_pose) return tl::unexpected(Error{ErrorKind::kUsage, "the truth does not have the pose that holds the map still"});
  return compose(covariances.state().pose(held), inverse(*true_pose));
}

/// Steps from the estimate to the truth, by variable, and which of them are known.
struct Errors {
  Eigen::VectorXd steps;
  std::vector<bool> poses;
  std::vector<bool> features;
  std::vector<bool> all;
};

template <int Dim>
Errors errors_of(const JointSystem<Dim>& system, const Piece<Dim>& piece, const Truth<Dim>& truth, const Pose<Dim>& frame) {
  const NormalEquations& equations = system.equations();
  const auto count = static_cast<std::size_t>(equations.variable_count());
  Errors errors{Eigen::VectorXd::Zero(equations.size()), std::vector<bool>(count), std::vector<bool>(count), {}};
  for (std::size_t v = 0; v < count; ++v) {
    const auto variable = static_cast<Index>(v);
    const auto place = static_cast<std::size_t>(system.place_of_variable(variable));
    auto step = errors.steps.segment(equations.offset(variable), equations.dof(variable));
    if (place < piece.poses.size()) {
      const auto& pose = truth.poses[static_cast<std::size_t>(piece.poses[place])];
      errors.poses[v] = pose.has_value();
      if (pose) step = local(piece.state.poses[place], compose(frame, *pose));
    } else {
      const std::size_t f = place - piece.poses.size();
      const auto& feature = truth.features[static_cast<std::size_t>(piece.features[f])];
      errors.features[v] = feature.has_value();
      if (feature) step = transform(frame, *feature) - piece.state.features[f];
    }
  }
  for (std::size_t v = 0; v < count; ++v) errors.all.push_back(errors.poses[v] || errors.features[v]);
  return errors;
}

Expected<Nees> nees_of(const NormalEquations& equations, const Eigen::VectorXd& steps, const std::vector<bool>& is_known) {
  Nees nees;
  for (Index v = 0; v < equations.variable_count(); ++v) {
    if (is_known[static_cast<std::size_t>(v)]) nees.dimensions += equations.dof(v);
  }
  if (nees.dimensions == 0) return nees;
  const auto value = equations.least_curvature(steps, is_known);
  if (!value) return bad_input("the covariances are not finite: something is free to move");
  nees.value = *value;
  return nees;
}

}  // namespace

double Nees::least() const {
  return chi_squared_quantile(0.01, static_cast<double>(dimensions));
}
double Nees::most() const {
  return chi_squared_quantile(0.99, static_cast<double>(dimensions));
}
double Nees::probability() const {
  return chi_squared_upper_tail(value, static_cast<double>(dimensions));
}

template <int Dim>
Expected<Consistency> consistency(const MapCovariances<Dim>& covariances, const Truth<Dim>& truth,
                                  const std::stop_token& stop) {
  const auto frame = frame_of(covariances, truth);
  if (!frame) return tl::unexpected(frame.error());
  const Network<Dim> network = uneliminated(covariances);
  Piece<Dim> piece = whole_of(network);
  set_to_values(covariances.state(), piece);
  place_fixed_poses(network, piece);
  JoinProblem<Dim> problem(piece, gauge_of(network, piece));
  problem.linearise();
  const NormalEquations& equations = problem.system().equations();
  const Errors errors = errors_of(problem.system(), piece, truth, *frame);
  if (std::none_of(errors.all.begin(), errors.all.end(), [](bool known) { return known; })) {
    return tl::unexpected(Error{ErrorKind::kUsage, "the truth has no pose or feature of the map"});
  }
  Consistency result;
  for (const auto& [nees, is_known] :
       {std::pair{&result.poses, &errors.poses}, {&result.features, &errors.features}, {&result.joint, &errors.all}}) {
    if (stop.stop_requested()) return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted while weighing the errors"});
    auto value = nees_of(equations, errors.steps, *is_known);
    if (!value) return tl::unexpected(value.error());
    *nees = *value;
  }
  return result;
}

template Expected<Consistency> consistency(const MapCovariances<2>&, const Truth<2>&, const std::stop_token&);
template Expected<Consistency> consistency(const MapCovariances<3>&, const Truth<3>&, const std::stop_token&);

}  // namespace mapjoin
