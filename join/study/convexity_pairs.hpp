// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The random states between which the objective is evaluated.

#include <cstdint>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/join/study/convexity_states.hpp>
#include <mapjoin/model/enum_names.hpp>
#include <string>
#include <vector>

namespace mapjoin {

enum class StateSource : std::uint8_t {
  kBox,    ///< Start::kRandom: positions uniform over the bounding box of the composed start, rotations uniform.
  kDrift,  ///< Composed along the spanning tree from measurements with errors of their stated covariance times `spread`².
};

constexpr auto enum_names(StateSource) {
  return std::to_array<EnumName<StateSource>>({{StateSource::kBox, "box"}, {StateSource::kDrift, "drift"}});
}

/// Draws random states of one joining system. Headings are within half a turn of those of `reference` (kBox), or have turned
/// with the errors (kDrift).
template <int Dim>
class StateSampler {
 public:
  /// `composed` is the composed start. All must outlive the sampler. `spread` multiplies the errors of kDrift.
  StateSampler(StateSource source, double spread, const PartialMap<Dim>& composed, const JoiningSystem<Dim>& system,
               const Values<Dim>& reference);

  /// A random state; the same seed gives the same one.
  Values<Dim> draw(std::uint64_t seed) const;

 private:
  Values<Dim> draw_from_box(std::uint64_t seed) const;
  Values<Dim> draw_drifted(std::uint64_t seed) const;

  StateSource source_;
  double spread_;
  const PartialMap<Dim>& composed_;
  const JoiningSystem<Dim>& system_;
  const Values<Dim>& reference_;
  RelativeCoordinates<Dim> coordinates_;
  std::vector<Eigen::MatrixXd> map_deviations_;  // S with S Sᵀ = W⁻¹, per map
};

}  // namespace mapjoin
