// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The transformation from the frame of the truth to that of the map; nullopt if the truth lacks the anchored pose.
template <int Dim>
std::optional<Pose<Dim>> frame_of(const MapCovariances<Dim>& covariances, const Truth<Dim>& truth) {
  if (covariances.anchored().size() != 1) return Pose<Dim>{};
  const PoseIndex anchored = covariances.anchored().front();
  const auto& true_pose = truth.poses[anchored];
  if (!true_pose) return std::nullopt;
  return compose(covariances.state().pose(anchored), inverse(*true_pose));
}

/// Steps from the estimate to the truth, by variable, and which of them are known.
struct Errors {
  Eigen::VectorXd steps;
  Table<Variable, bool> poses;
  Table<Variable, bool> features;
  Table<Variable, bool> all;
};

template <int Dim>
Errors errors_of(const MapCovariances<Dim>& covariances, const Truth<Dim>& truth, const Pose<Dim>& frame) {
  const NormalEquations& equations = covariances.equations();
  const Values<Dim>& state = covariances.state();
  const Table<Variable, bool> none(equations.variables().size());
  Errors errors{Eigen::VectorXd::Zero(equations.size()), none, none, none};
  const auto add = [&](auto of, const auto& step, Table<Variable, bool>& known) {
    const Variable variable = covariances.variable(of);
    if (variable == kConstant) return;
    errors.steps.segment(equations.offset(variable), equations.dof(variable)) = step;
    known[variable] = errors.all[variable] = true;
  };
  for (const PoseIndex p : indices(state.poses)) {
    if (truth.poses[p]) add(p, local(state.poses[p], compose(frame, *truth.poses[p])), errors.poses);
  }
  for (const FeatureIndex f : indices(state.features)) {
    if (truth.features[f]) add(f, transform(frame, *truth.features[f]) - state.features[f], errors.features);
  }
  return errors;
}

Expected<Nees> nees_of(const NormalEquations& equations, const Eigen::VectorXd& steps, const Table<Variable, bool>& is_known) {
  Nees nees;
  for (const Variable v : equations.variables()) {
    if (is_known[v]) nees.dimensions += equations.dof(v);
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
  const auto has_value = [](const auto& value) { return value.has_value(); };
  if (std::ranges::none_of(truth.poses, has_value) && std::ranges::none_of(truth.features, has_value)) {
    return tl::unexpected(Error{ErrorKind::kUsage, "the truth has no pose or feature of the map"});
  }
  Consistency result;
  const auto frame = frame_of(covariances, truth);
  if (!frame) return result;
  const Errors errors = errors_of(covariances, truth, *frame);
  for (const auto& [nees, is_known] :
       {std::pair{&result.poses, &errors.poses}, {&result.features, &errors.features}, {&result.joint, &errors.all}}) {
    if (stop.stop_requested()) return interrupted("weighing the errors");
    auto value = nees_of(covariances.equations(), errors.steps, *is_known);
    if (!value) return tl::unexpected(value.error());
    *nees = *value;
  }
  return result;
}

template Expected<Consistency> consistency(const MapCovariances<2>&, const Truth<2>&, const std::stop_token&);
template Expected<Consistency> consistency(const MapCovariances<3>&, const Truth<3>&, const std::stop_token&);

}  // namespace mapjoin
