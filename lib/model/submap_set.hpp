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

/// The input of a join: local maps, and observations that stand on their own (one-step maps), over shared poses and features.
template <int Dim>
struct SubmapSet {
  std::string source;  ///< The file or folder it was read from, for messages.
  PoseIds poses;
  FeatureIds features;

  FactorGraph<Dim> graph;
  std::vector<Segment> segments;
  Conventions conventions;
  /// True if the user said that features of the same id are the same in the several inputs that it was stored from.
  bool features_are_shared = false;
};

/// Checks a set made in memory. kBadInput unless it names its poses and features once each, its maps and observations refer to
/// poses and features of the set, none twice, and their numbers are valid, or a factor is
/// dropped by its loss; a pose may be fixed twice only at the same place.
template <int Dim>
Expected<void> check_content(const SubmapSet<Dim>& set);

/// True if a local map is of this segment and keeps all its poses.
template <int Dim>
bool keeps_all_of(const LocalMap<Dim>& map, const Segment& segment);

/// Checks the segments of a set. kBadInput unless there are poses, each in a segment; each segment begins at the end of the one
/// before or, in another session, at the pose after it; and the segments that are maps match the local maps, which keep all
/// their poses.
template <int Dim>
Expected<void> check_segments(const SubmapSet<Dim>& set);

}  // namespace mapjoin
