// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The input of a join: local maps without their submap-local features, and single observations.

#include <mapjoin/localmap/marginalise.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <vector>

namespace mapjoin {

/// A view of a log or a submap set, which must outlive it. Observations are pointers, as a log has millions.
template <int Dim>
struct SubmapGraph {
  std::size_t pose_count = 0;
  std::size_t feature_count = 0;
  std::vector<MarginalisedMap<Dim>> maps;  ///< Local maps of the segments that are maps, in their order.
  FactorSelection<Dim> factors;            ///< Single observations: those of raw segments, and closures.
  FactorSelection<Dim> priors;
  std::vector<FixedPose<Dim>> fixed;
  std::vector<Segment> segments;
  Table<FeatureIndex, bool> is_local;  ///< True for a feature eliminated within its map.
  Table<PoseIndex, bool> is_joined;    ///< True for a pose of the joined state.
};

/// The submap graph of a log split into segments, with the local maps of those that are maps. Features marked in `elsewhere`,
/// to which others refer, are local to no map; if it is empty, none is marked.
template <int Dim>
SubmapGraph<Dim> submap_graph_of(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps,
                                 Table<FeatureIndex, bool> elsewhere = {});

/// The submap graph of a set of local maps; `maps` are those of the set, and may have been moved out of it.
template <int Dim>
SubmapGraph<Dim> submap_graph_of(const SubmapSet<Dim>& set, std::vector<LocalMap<Dim>> maps);
template <int Dim>
SubmapGraph<Dim> submap_graph_of(const SubmapSet<Dim>& set) {
  return submap_graph_of(set, set.graph.submaps);
}

}  // namespace mapjoin
