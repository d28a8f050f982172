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

/// Bad input unless there are poses, as many segments are maps as there are maps, and the segments, in the order of their first
/// poses, hold all poses of the set.
template <int Dim>
Expected<void> check_segments(const SubmapSet<Dim>& set);

}  // namespace mapjoin
