// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log cut into sessions, as if driven on several days.

#include <mapjoin/io/merged_logs.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <string>
#include <tests/support/random.hpp>
#include <tests/support/starts.hpp>
#include <utility>
#include <vector>

namespace mapjoin::testing {

/// The poses of one of `sessions` sessions of equal length.
template <int Dim>
IndexRange<PoseIndex> session_of(const Log<Dim>& log, std::size_t session, std::size_t sessions) {
  return {PoseIndex(session * log.poses.size() / sessions), PoseIndex((session + 1) * log.poses.size() / sessions)};
}

/// One of `sessions` sessions as a log of its own: pose ids from 0 on, initial values by dead reckoning in a random frame,
/// without the edges that lead out of it.
template <int Dim>
Log<Dim> cut_session(const Log<Dim>& log, std::size_t session, std::size_t sessions) {
  const auto own = session_of(log, session, sessions);
  const auto id = [&](PoseIndex pose) { return PoseId{0, static_cast<std::uint64_t>(pose - own.first)}; };
  const Pose<Dim> frame = Random(static_cast<unsigned>(session) + 1).pose<Dim>(1000.0, 3.0);
  const Values<Dim> values = odometry_start(log);
  LogBuilder<Dim> builder("session " + std::to_string(session));
  for (PoseIndex p = own.first; p < own.last; ++p) builder.add_pose(id(p), compose(frame, values.poses[p]));
  for (const auto& edge : log.edges()) {
    if (own.contains(edge.base) && own.contains(edge.target)) {
      builder.add_pose_edge(id(edge.base), id(edge.target), edge.measured, edge.information);
    }
  }
  for (const auto& seen : log.observations()) {
    if (!own.contains(seen.base)) continue;
    builder.add_observation(id(seen.base), log.features[seen.target], seen.measured, seen.information);
    builder.add_feature(log.features[seen.target]);
  }
  return std::move(builder).finish().value();
}

/// The two halves of a log as sessions that share no names of features.
template <int Dim>
Log<Dim> in_two_sessions(const Log<Dim>& log) {
  std::vector<Log<Dim>> logs = {cut_session(log, 0, 2), cut_session(log, 1, 2)};
  return merged(std::move(logs), {.own_features = true}).value();
}

/// The log without edges between its `sessions` sessions.
template <int Dim>
Log<Dim> without_cut_edges(const Log<Dim>& log, std::size_t sessions) {
  LogBuilder<Dim> builder(log.source);
  for (std::size_t k = 0; k < sessions; ++k) {
    const auto own = session_of(log, k, sessions);
    for (const auto& edge : log.edges()) {
      if (own.contains(edge.base) && own.contains(edge.target)) {
        builder.add_pose_edge(log.poses[edge.base], log.poses[edge.target], edge.measured, edge.information);
      }
    }
  }
  for (const auto& seen : log.observations()) {
    builder.add_observation(log.poses[seen.base], log.features[seen.target], seen.measured, seen.information);
  }
  return std::move(builder).finish().value();
}

}  // namespace mapjoin::testing
