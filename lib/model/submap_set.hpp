// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A set of local maps, and of observations that stand on their own, over shared poses and features.

#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/factor_graph.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/segment.hpp>
#include <string>
#include <vector>

namespace mapjoin {

/// What there is to join: local maps, and observations that stand on their own (one-step maps), over shared poses and features.
template <int Dim>
struct SubmapSet {
  std::string source;  ///< The file or folder it was read from, for messages.
  PoseIds poses;
  FeatureIds features;

  FactorGraph<Dim> graph;
  std::vector<Segment> segments;
  Conventions conventions;
};

/// Bad input unless a set made in memory names its poses and features once each, and its maps and observations are over poses
/// and features of the set, over none of them twice, with sound numbers; a pose may be fixed twice only at the same place.
template <int Dim>
Expected<void> check_content(const SubmapSet<Dim>& set);

/// Whether a local map is of a segment and keeps every pose of it.
template <int Dim>
bool keeps_all_of(const LocalMap<Dim>& map, const Segment& segment);

/// Bad input unless there are poses, each in a segment; each segment begins at the end of the one before or, as another session
/// does, at the pose after it; and the segments that are maps are those of the local maps, which keep all their poses.
template <int Dim>
Expected<void> check_segments(const SubmapSet<Dim>& set);

}  // namespace mapjoin
