// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log cut in space: each rank has the factors whose base lies in one of its regions.

#include <mapjoin/distributed/mpi/holdings.hpp>
#include <mapjoin/distributed/reading/log_share.hpp>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/join/joined_state.hpp>

namespace mapjoin::distributed {

/// Poses and features by one number, first the poses: by the indices of all names.
struct Numbering {
  std::size_t poses = 0;
  std::size_t features = 0;

  std::size_t count() const { return poses + features; }
  std::int32_t number(PoseIndex pose) const { return pose.value; }
  std::int32_t number(FeatureIndex feature) const { return static_cast<std::int32_t>(poses) + feature.value; }
  PoseOrFeature index(std::int32_t number) const {
    const auto first_feature = static_cast<std::int32_t>(poses);
    return number < first_feature ? PoseOrFeature(PoseIndex(number)) : FeatureIndex(number - first_feature);
  }
};

/// The poses and features that its factors refer to have places in a region. Vectors are over StateVariables of these.
template <int Dim>
struct Region {
  Table<PoseIndex, PoseIndex> poses;           ///< By place, the index among all names, ascending.
  Table<FeatureIndex, FeatureIndex> features;  ///< Likewise.
  Values<Dim> start;                           ///< By place.
  std::vector<PoseIndex> anchored;             ///< Places of poses that are not free, ascending.
  std::string factors;                         ///< As bytes, which take two thirds of their memory; see factors_of().
  std::int64_t measured_rows = 0;
};

/// The factors of a region, whose poses and features are places.
template <int Dim>
FactorGraph<Dim> factors_of(const Region<Dim>& region);

/// A region as a partial map, by its places, with these factors of it and these values.
template <int Dim>
PartialMap<Dim> partial_map_of(const Region<Dim>& region, const FactorGraph<Dim>& graph, Values<Dim> values);

template <int Dim>
StateVariables<Dim> variables_of(const Region<Dim>& region) {
  return {region.poses.size(), region.features.size(), region.anchored};
}

/// A place of a region as the index among all names.
template <int Dim>
PoseOrFeature index_in(const Region<Dim>& region, const PoseOrFeature& placed) {
  return std::visit([&](auto place) -> PoseOrFeature { return index_in(region, place); }, placed);
}

template <int Dim>
struct Regions {
  Numbering numbering;
  std::size_t per_rank = 1;      ///< Rank r has the regions from r·per_rank on.
  std::vector<Region<Dim>> own;  ///< Of this rank.
  std::vector<Holding> shared;   ///< What several regions have, on all ranks; at the same value in each.
};

/// The regions of a log, so many on each rank, whose shares and their start are given up for them. Bad input, the same on all
/// ranks, where a feature is never observed.
template <int Dim>
Expected<Regions<Dim>> regions_of(const Communicator& comm, const LogPart<Dim>& whole, LogShare<Dim> share, Values<Dim> start,
                                  std::size_t per_rank);

}  // namespace mapjoin::distributed
