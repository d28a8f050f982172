// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Redistribution of a log from shares, cut in time, to regions, cut in space: parts of the graph of its poses and features,
// with few factors between them.

#include <mapjoin/distributed/reading/log_share.hpp>

namespace mapjoin::distributed {

/// The region, of `count`, of each pose of a log: with equally many poses in each, but for a few per cent. The first rank
/// sees the graph of the whole log without its measurements, with runs of poses taken together if there are more than a
/// million.
template <int Dim>
Table<PoseIndex, std::int32_t> region_of_poses(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
                                               std::size_t count);

/// The data that go from one share to one region: factors, and values of the poses and features that they mention, by the
/// indices of all names.
template <int Dim>
struct Dealt {
  std::vector<PoseFactor<Dim>> pose_factors;
  std::vector<FeatureFactor<Dim>> feature_factors;
  std::vector<PoseIndex> poses;
  std::vector<Pose<Dim>> pose_values;
  std::vector<FeatureIndex> features;
  std::vector<Point<Dim>> feature_values;
};

template <int Dim>
std::string encoded(const Dealt<Dim>& dealt);
template <int Dim>
Dealt<Dim> decoded(const std::string& message);

/// Deals out a share, whose log has poses and features by its own indices. An observation goes to the region of its pose, a
/// factor of two poses to that of the one with fewer such factors: a pose that many are measured from is shared, not all of
/// these.
template <int Dim>
class Dealer {
 public:
  /// `regions` are those of all poses; each rank has `per_rank` consecutive ones.
  Dealer(const Table<PoseIndex, std::int32_t>& regions, std::size_t per_rank, const LogShare<Dim>& share,
         const Values<Dim>& values);

  /// The messages to the k-th region of each of `ranks` ranks.
  std::vector<std::string> messages(std::size_t k, std::size_t ranks);

 private:
  /// The data for one region, and which poses and features of the share are there already.
  struct Hand {
    Dealt<Dim> dealt;
    Table<PoseIndex, bool> has_pose;
    Table<FeatureIndex, bool> has_feature;
  };
  /// The hand of the region of a pose, by its index among all names; null if that region is dealt in another turn.
  Hand* hand_of(PoseIndex pose);
  /// The pose to whose region a factor of two poses goes; all by their indices among all names.
  PoseIndex home_of(PoseIndex base, PoseIndex target) const;
  /// Deals a factor of the log to the region of the pose `home`.
  template <typename Factor>
  void deal(Factor o, PoseIndex home, std::vector<Factor> Dealt<Dim>::*factors);
  /// The end of a factor of `apart` that is of this share.
  PoseIndex own_place(const PoseFactor<Dim>& o) const;
  void deal_apart(const PoseFactor<Dim>& o);
  void give(PoseIndex p, Hand& hand) const;
  void give(FeatureIndex f, Hand& hand) const;

  const Table<PoseIndex, std::int32_t>& regions_;
  std::size_t per_rank_;
  const LogShare<Dim>& share_;
  const Values<Dim>& values_;
  IndexOf<PoseIndex, PoseIndex> place_of_;  ///< Place of a pose by its index among all names.
  Table<PoseIndex, std::int32_t> degrees_;  ///< Numbers of the share's factors of two poses, by index among all names.
  std::vector<PoseIndex> told_by_none_;     ///< Poses that only factors of other shares mention.
  std::size_t turn_ = 0;
  std::vector<Hand> hands_;  ///< Hands by rank.
};

}  // namespace mapjoin::distributed
