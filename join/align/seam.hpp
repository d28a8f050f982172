// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Where two pieces meet: the observations that tell one placement of the second in the frame of the first from another.

#include <mapjoin/join/align/piece.hpp>
#include <vector>

namespace mapjoin {

/// Closures between the pieces, and the second one's observations that tie what only it holds to what both hold: placing it
/// moves one end of each. At most kMost of a kind, spread evenly: more would not change the choice.
template <int Dim>
class Seam {
 public:
  static constexpr std::size_t kMost = 1000;

  /// `closures` may hold others, too. Both pieces must outlive it.
  Seam(const Piece<Dim>& a, const Piece<Dim>& b, const std::vector<const PoseObservation<Dim>*>& closures);

  /// Their chi2 with `b` placed in the frame of `a`; what both hold keeps its value in `a`.
  double chi2(const Pose<Dim>& placement) const;

 private:
  /// A pose or a point, in the frame of `a`, or in that of `b` and placed with it.
  template <typename T>
  struct End {
    T value;
    bool is_placed;
  };
  template <typename Observation, typename Target>
  struct Tie {
    const Observation* observation;
    End<Pose<Dim>> base;
    End<Target> target;
  };
  struct MapTie {
    const LocalMap<Dim>* map;
    End<Pose<Dim>> base;
    std::vector<End<Pose<Dim>>> poses;
    std::vector<End<Point<Dim>>> features;
  };

  End<Pose<Dim>> end_of_pose(Index pose) const;
  End<Point<Dim>> end_of_feature(Index feature) const;

  const Piece<Dim>& a_;
  const Piece<Dim>& b_;
  std::vector<Tie<PoseObservation<Dim>, Pose<Dim>>> pose_ties_;
  std::vector<Tie<FeatureObservation<Dim>, Point<Dim>>> feature_ties_;
  std::vector<MapTie> map_ties_;
};

}  // namespace mapjoin
