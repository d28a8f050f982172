// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The observations that tell alignments of one partial map in the frame of another apart.

#include <mapjoin/join/align/partial_map.hpp>
#include <vector>

namespace mapjoin {

/// Closures between two partial maps, and the second one's observations between its own and the shared poses and features: the
/// alignment moves one end of each. At most kMost of a kind, spread evenly: more would not change the choice.
template <int Dim>
class SharedFactors {
 public:
  static constexpr std::size_t kMost = 1000;

  /// `closures` may include others. Both partial maps must outlive this.
  SharedFactors(const PartialMap<Dim>& a, const PartialMap<Dim>& b, const std::vector<const PoseFactor<Dim>*>& closures);

  /// The chi2 of the shared factors with `b` placed in the frame of `a`; poses and features of both keep their values in `a`.
  double chi2(const Pose<Dim>& alignment) const;

 private:
  /// A pose or a point in the frame of `a` or, if placed, in that of `b`.
  template <typename T>
  struct End {
    T value;
    bool is_placed;
  };
  template <typename Observation, typename Target>
  struct PlacedFactor {
    const Observation* observation;
    End<Pose<Dim>> base;
    End<Target> target;
  };
  struct PlacedMap {
    const LocalMap<Dim>* map;
    End<Pose<Dim>> base;
    std::vector<End<Pose<Dim>>> poses;
    std::vector<End<Point<Dim>>> features;
  };

  End<Pose<Dim>> end_of_pose(PoseIndex pose) const;
  End<Point<Dim>> end_of_feature(FeatureIndex feature) const;

  const PartialMap<Dim>& a_;
  const PartialMap<Dim>& b_;
  std::vector<PlacedFactor<PoseFactor<Dim>, Pose<Dim>>> pose_factors_;
  std::vector<PlacedFactor<FeatureFactor<Dim>, Point<Dim>>> feature_factors_;
  std::vector<PlacedMap> maps_;
};

}  // namespace mapjoin
