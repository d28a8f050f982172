// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log cut in space: each rank has the factors whose base lies in one of its regions.

#include <mapjoin/distributed/holdings.hpp>
#include <mapjoin/distributed/log_share.hpp>
#include <utility>

namespace mapjoin::distributed {

/// Poses and features by one number, first the poses: by the indices of all names.
struct Numbering {
  std::size_t poses = 0;
  std::size_t features = 0;

  std::size_t count() const { return poses + features; }
  std::int32_t number(PoseIndex pose) const { return pose.value; }
  std::int32_t number(FeatureIndex feature) const { return static_cast<std::int32_t>(poses) + feature.value; }
  bool is_pose(std::int32_t number) const { return number < static_cast<std::int32_t>(poses); }
  PoseIndex pose(std::int32_t number) const { return PoseIndex(number); }
  FeatureIndex feature(std::int32_t number) const { return FeatureIndex(number - static_cast<std::int32_t>(poses)); }
};

/// What the factors of a region mention has places in it. Vectors are over the free poses, by place, then the features.
template <int Dim>
struct Region {
  Table<PoseIndex, PoseIndex> poses;           ///< By place, the index among all names, ascending.
  Table<FeatureIndex, FeatureIndex> features;  ///< Likewise.
  Values<Dim> start;                           ///< By place.
  std::vector<PoseIndex> anchored;             ///< Places of poses that are not free, ascending.
  std::string factors;                         ///< As bytes, which take two thirds of their memory; see factors_of().
  std::int64_t measured_rows = 0;

  /// Entries of vectors.
  Eigen::Index size() const { return first_feature_entry() + Dim * static_cast<Eigen::Index>(features.size()); }
  Eigen::Index first_feature_entry() const { return kPoseDof<Dim> * static_cast<Eigen::Index>(poses.size() - anchored.size()); }
  /// Calls f(place, first entry in vectors) for every free pose.
  template <typename F>
  void for_each_free_pose(F&& f) const {
    auto next = anchored.begin();
    Eigen::Index entry = 0;
    for (const PoseIndex place : indices(poses)) {
      if (next != anchored.end() && *next == place) {
        ++next;
      } else {
        f(place, std::exchange(entry, entry + kPoseDof<Dim>));
      }
    }
  }
};

/// The factors of a region, whose poses and features are places.
template <int Dim>
FactorGraph<Dim> factors_of(const Region<Dim>& region);

/// A place of a region as the index among all names.
template <int Dim, typename Index>
PoseOrFeature name_of(const Region<Dim>& region, Index place) {
  if constexpr (std::is_same_v<Index, PoseIndex>) {
    return region.poses[place];
  } else {
    return region.features[place];
  }
}

template <int Dim>
struct Regions {
  Numbering numbering;
  std::size_t per_rank = 1;      ///< Rank r has the regions from r·per_rank on.
  std::vector<Region<Dim>> own;  ///< Of this rank.
  std::vector<Holding> shared;   ///< What several regions mention, on all ranks; at the same value in each.
};

/// The regions of a log, so many on each rank, whose shares and their start are given up for them. Bad input, the same on all
/// ranks, where a feature is never observed.
template <int Dim>
Expected<Regions<Dim>> regions_of(const Communicator& comm, const LogPart<Dim>& whole, LogShare<Dim> share, Values<Dim> start,
                                  std::size_t per_rank);

}  // namespace mapjoin::distributed
