// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The joined state (30), its normal equations, and the observations that stand on their own; those of the local maps are added
// by the caller.

#include <Eigen/Core>
#include <mapjoin/join/align/gauge.hpp>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/model/accumulate.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <span>
#include <vector>

namespace mapjoin {

template <int Dim>
class JoiningSystem {
 public:
  /// `partial` gives observations and start; it may go afterwards, the observations and maps must stay. `order` is that of
  /// the elimination, by places (see place_of_variable); where it is empty, one is found.
  JoiningSystem(const PartialMap<Dim>& partial, const Gauge<Dim>& gauge, Engine engine = Engine::kFronts,
                const std::vector<PoseOrFeature>& order = {});

  /// Normal equations at the estimate; returns chi2. `add_map(m, sink)` adds those of map m, whose variables are base, poses
  /// and features, and returns its chi2.
  template <typename AddMap>
  double linearise(AddMap&& add_map) {
    equations_.set_zero();
    return equations_.accumulate_factors([&](std::size_t factor, NormalEquations::Sink sink) {
      if (factor >= first_map_factor_) return add_map(factor - first_map_factor_, sink);
      return with_linear_observation(factor, [&](const auto& linear) { return accumulate(linear, sink); });
    });
  }
  /// Adds the curvature of the observations (see accumulate_curvature), and of the maps by `add_map(m, sink)`.
  template <typename AddMap>
  void add_curvature(AddMap&& add_map) {
    equations_.accumulate_factors([&](std::size_t factor, NormalEquations::Sink sink) {
      if (factor < first_map_factor_) {
        with_linear_observation(factor, [&](const auto& linear) { accumulate_curvature(linear, sink); });
      } else {
        add_map(factor - first_map_factor_, sink);
      }
      return 0.0;
    });
  }
  double observations_chi2(const Values<Dim>& state) const;

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
  /// Puts the observations and maps of another partial map and gauge, which differ in their numbers only, in place of these.
  void observe(const PartialMap<Dim>& partial, const Gauge<Dim>& gauge) { place_observations(partial, gauge); }

  /// What a factor of the normal equations is: its list among the three, and its place there.
  struct Source {
    enum Kind { kPoseFactor, kFeatureFactor, kMap } kind;
    std::size_t place;
  };
  Source source_of(std::size_t factor) const;
  /// Rows of the measurement of a factor.
  Eigen::Index rows(std::size_t factor) const;
  /// f(the observation linearised at the estimate), of a factor that is no map.
  template <typename F>
  auto with_linear_observation(std::size_t factor, F&& f) const {
    const auto [kind, place] = source_of(factor);
    if (kind == Source::kPoseFactor) {
      const auto& [o, base, target] = pose_factors_[place];
      return f(mapjoin::linearise(*o, estimate_.pose(base), estimate_.pose(target)));
    }
    const auto& [o, base, target] = feature_factors_[place];
    return f(mapjoin::linearise(*o, estimate_.pose(base), estimate_.features[target]));
  }

  Values<Dim>& estimate() { return estimate_; }
  const Values<Dim>& estimate() const { return estimate_; }
  /// The estimate moved by a step.
  Values<Dim> retracted(const Eigen::VectorXd& step) const;
  StepSize step_size(const Eigen::VectorXd& step) const;
  /// kConstant for the World and for poses that are anchored.
  Variable variable(PoseIndex place) const { return place == kWorld ? kConstant : pose_variables_[place]; }
  Variable variable(FeatureIndex place) const { return first_feature_variable_ + place.value; }
  bool is_anchored(PoseIndex place) const { return variable(place) == kConstant; }
  PoseOrFeature place_of_variable(Variable variable) const { return places_[variable]; }

 private:
  void number_variables(const Gauge<Dim>& gauge);
  void place_observations(const PartialMap<Dim>& partial, const Gauge<Dim>& gauge);
  NormalEquations make_equations(Engine engine, const std::vector<PoseOrFeature>& order) const;

  Values<Dim> estimate_;
  std::vector<Placed<PoseFactor<Dim>>> pose_factors_;
  std::vector<Placed<FeatureFactor<Dim>>> feature_factors_;
  std::vector<PlacedMap> maps_;
  Table<PoseIndex, Variable> pose_variables_;  // kConstant where held
  Variable first_feature_variable_ = 0;
  Table<Variable, PoseOrFeature> places_;
  std::size_t first_map_factor_ = 0;
  NormalEquations equations_;
};

}  // namespace mapjoin
