// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Joining as a least-squares problem over the joined state (30): each local map is one integrated observation (paper's (31),
// (32)), beside single observations.

#include <Eigen/Core>
#include <functional>
#include <mapjoin/join/align/gauge.hpp>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/join/joined_state.hpp>
#include <mapjoin/model/accumulate.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// A LeastSquaresProblem over the joined state of a partial map.
template <int Dim>
class JoiningSystem {
 public:
  /// Takes observations and start from `partial`, which may be destroyed afterwards; the observations and maps must outlive the
  /// system. `order` is the elimination order by places (see place_of_variable); if it is empty, one is computed.
  JoiningSystem(const PartialMap<Dim>& partial, const Gauge<Dim>& gauge, Engine engine = Engine::kFronts,
                const std::vector<PoseOrFeature>& order = {});
  /// A system with a given solver that leaves the variables at the places `border` to others; they come last, in this order.
  JoiningSystem(const PartialMap<Dim>& partial, const Gauge<Dim>& gauge, std::unique_ptr<SparseSolver> solver,
                const std::vector<PoseOrFeature>& border, const std::vector<PoseOrFeature>& order = {});

  double linearise();
  void add_curvature();
  const Eigen::VectorXd& gradient() const { return equations_.gradient(); }
  DiagonalMetric metric() const { return DiagonalMetric(equations_.diagonal()); }
  double curvature(const Eigen::VectorXd& v) const { return equations_.curvature(v); }
  std::optional<Variable> factorise(double damping) { return equations_.factorise(damping); }
  Eigen::VectorXd solve() const { return equations_.solve(gradient()); }
  StepSize step_size(const Eigen::VectorXd& step) const { return variables_.step_size(step); }
  /// The moves (m) that the rounding of the largest coordinate hides.
  double rounding() const;
  double try_step(const Eigen::VectorXd& step) { return try_state(variables_.retracted(estimate_, step)); }
  /// The chi2 of a state, which becomes the candidate.
  double try_state(Values<Dim> candidate);
  void accept() { std::swap(estimate_, candidate_); }

  /// The normal equations, with their pattern, ordering and symbolic factor.
  NormalEquations& equations() { return equations_; }
  const NormalEquations& equations() const { return equations_; }

  /// An observation whose base and target are places of the joined state, or the World.
  template <typename Observation>
  struct Placed {
    const Observation* observation;
    PoseIndex base;
    decltype(Observation::target) target;
  };
  const std::vector<Placed<PoseFactor<Dim>>>& pose_factors() const { return pose_factors_; }
  const std::vector<Placed<FeatureFactor<Dim>>>& feature_factors() const { return feature_factors_; }
  /// A map whose indices are places of the joined state.
  struct PlacedMap {
    const LocalMap<Dim>* map;
    PoseIndex base;
    std::vector<PoseIndex> poses;
    std::vector<FeatureIndex> features;
  };
  const std::vector<PlacedMap>& maps() const { return maps_; }
  /// chi2 of a local map as an observation of `state`.
  static double map_chi2(const PlacedMap& placed, const Values<Dim>& state);
  /// Replaces the observations and maps by those of another partial map and gauge, which may differ in their numbers only.
  void observe(const PartialMap<Dim>& partial, const Gauge<Dim>& gauge);

  /// The origin of a factor of the normal equations: one of the three lists, and the place there.
  struct Source {
    enum Kind { kPoseFactor, kFeatureFactor, kMap } kind;
    std::size_t place;
  };
  Source source_of(std::size_t factor) const;
  /// The number of rows of a factor's measurement.
  Eigen::Index rows(std::size_t factor) const;
  /// Calls f with the factor linearised at the estimate, a LinearObservation or a LinearMap, and returns its result.
  template <typename F>
  auto with_linear_factor(std::size_t factor, F&& f) const {
    const auto [kind, place] = source_of(factor);
    if (kind == Source::kPoseFactor) {
      const auto& [o, base, target] = pose_factors_[place];
      return f(mapjoin::linearise(*o, estimate_.pose(base), estimate_.pose(target)));
    }
    if (kind == Source::kFeatureFactor) {
      const auto& [o, base, target] = feature_factors_[place];
      return f(mapjoin::linearise(*o, estimate_.pose(base), estimate_.features[target]));
    }
    const PlacedMap& placed = maps_[place];
    return f(mapjoin::linearise(
        *placed.map, estimate_.pose(placed.base), [&](std::size_t p) { return estimate_.pose(placed.poses[p]); },
        [&](std::size_t k) { return estimate_.features[placed.features[k]]; }));
  }

  Values<Dim>& estimate() { return estimate_; }
  const Values<Dim>& estimate() const { return estimate_; }
  /// The variable at a place; kConstant for the World and for anchored poses.
  template <typename Place>
  Variable variable(Place place) const {
    return variables_(place);
  }
  bool is_anchored(PoseIndex place) const { return variable(place) == kConstant; }
  PoseOrFeature place_of_variable(Variable variable) const { return variables_.place(variable); }

 private:
  /// The variables at these places, without anchored poses.
  std::vector<Variable> variables_at(const std::vector<PoseOrFeature>& places) const;
  NormalEquations make_equations(std::unique_ptr<SparseSolver> solver, const Ordering& ordering) const;
  double chi2(const Values<Dim>& state) const;

  StateVariables<Dim> variables_;
  Values<Dim> estimate_;
  Values<Dim> candidate_;
  std::vector<Placed<PoseFactor<Dim>>> pose_factors_;
  std::vector<Placed<FeatureFactor<Dim>>> feature_factors_;
  std::vector<PlacedMap> maps_;
  std::size_t first_map_factor_ = 0;
  NormalEquations equations_;
};

/// The places of some observations, in a row in memory, among those that a system has placed.
template <typename Placed, typename Observation>
std::vector<std::size_t> places_among(const std::vector<Placed>& placed, std::span<const Observation> observations) {
  std::vector<std::size_t> places(observations.size());
  for (std::size_t k = 0; k < placed.size(); ++k) {
    const auto o = static_cast<std::size_t>(placed[k].observation - observations.data());
    if (!std::less<>()(placed[k].observation, observations.data()) && o < observations.size()) places[o] = k;
  }
  return places;
}

}  // namespace mapjoin
