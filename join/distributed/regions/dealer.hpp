// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Redistribution of a log from shares, cut in time, to regions, cut in space: parts of the graph of its poses and features,
// with few factors between them.

#include <mapjoin/distributed/reading/log_share.hpp>

namespace mapjoin::distributed {

/// The region, of `count`, of each pose of a share: with equally many poses in each, but for a few per cent. The first rank
/// sees the graph of the whole log without its measurements, with runs of poses taken together if there are more than a
/// million.
template <int Dim>
Table<PoseIndex, std::size_t> region_of_poses(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
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

/// Deals out a share, whose log has poses and features by its own indices.
template <int Dim>
class Dealer {
 public:
  /// `regions` are those of the poses of the share; each rank has `per_rank` consecutive ones.
  Dealer(const Table<PoseIndex, std::size_t>& regions, std::size_t per_rank, const LogShare<Dim>& share,
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
  /// The hand of the region of a pose of the share; null if that region is dealt in another turn.
  Hand* hand_of(PoseIndex pose);
  template <typename Factor>
  void deal(Factor o, std::vector<Factor> Dealt<Dim>::*factors);
  /// The end of a factor of `apart` that is of this share.
  PoseIndex own_place(const PoseFactor<Dim>& o) const;
  /// Deals a factor of `apart` to the region of the end that is of this share.
  void deal_apart(const PoseFactor<Dim>& o);
  void give(PoseIndex p, Hand& hand) const;
  void give(FeatureIndex f, Hand& hand) const;

  const Table<PoseIndex, std::size_t>& regions_;
  std::size_t per_rank_;
  const LogShare<Dim>& share_;
  const Values<Dim>& values_;
  IndexOf<PoseIndex, PoseIndex> place_of_;  ///< Place of a pose by its index among all names.
  std::vector<PoseIndex> told_by_none_;     ///< Poses that only factors of other shares mention.
  std::size_t turn_ = 0;
  std::vector<Hand> hands_;  ///< Hands by rank.
};

}  // namespace mapjoin::distributed
