// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log cut in space: each rank has the factors of which a pose lies in one of its regions (see Dealer).

#include <mapjoin/distributed/mpi/holdings.hpp>
#include <mapjoin/distributed/reading/log_share.hpp>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/join/joined_state.hpp>

namespace mapjoin::distributed {

/// One numbering of poses and features, poses first, by the indices of all names.
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

/// A region of a log: the poses and features that its factors refer to have places in it, in the first one all fixed poses,
/// too. Vectors are over the StateVariables of these.
template <int Dim>
struct Region {
  Table<PoseIndex, PoseIndex> poses;           ///< Index among all names by place, ascending.
  Table<FeatureIndex, FeatureIndex> features;  ///< Index among all names by place, ascending.
  Values<Dim> start;                           ///< Initial values by place.
  std::vector<PoseIndex> anchored;             ///< Places of anchored poses, ascending.
  std::string factors;                         ///< Factors as bytes, in two thirds of their memory; see factors_of().
  std::int64_t measured_rows = 0;
};

/// The factors of a region, whose poses and features are places.
template <int Dim>
FactorGraph<Dim> factors_of(const Region<Dim>& region);

/// The partial map of a region, by its places, with these values; `graph` holds the factors of the region and must outlive it.
template <int Dim>
PartialMap<Dim> partial_map_of(const Region<Dim>& region, const FactorGraph<Dim>& graph, Values<Dim> values);

template <int Dim>
StateVariables<Dim> variables_of(const Region<Dim>& region) {
  return {region.poses.size(), region.features.size(), region.anchored};
}

template <int Dim>
struct Regions {
  Numbering numbering;
  std::size_t per_rank = 1;      ///< Rank r has the regions from r·per_rank on.
  std::vector<Region<Dim>> own;  ///< Regions of this rank.
  std::vector<Holding> shared;   ///< Poses and features that several regions have, at the same value in each; on all ranks.
};

/// The regions of a log, `per_rank` on each rank; its shares and their initial values are given up.
template <int Dim>
Regions<Dim> regions_of(const Communicator& comm, const LogPart<Dim>& whole, LogShare<Dim> share, Values<Dim> start,
                        std::size_t per_rank);

}  // namespace mapjoin::distributed
