// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/submap_set.hpp>

namespace mapjoin {
namespace {

template <typename Index, typename Id>
bool is_among(const Table<Index, Id>& names, Index index) {
  return indices(names).contains(index);
}

template <int Dim>
bool is_within(const LocalMap<Dim>& map, const SubmapSet<Dim>& set) {
  return is_among(set.poses, map.base) && std::ranges::all_of(map.poses, [&](auto p) { return is_among(set.poses, p); }) &&
         std::ranges::all_of(map.features, [&](auto f) { return is_among(set.features, f); });
}

template <typename Observation, typename Targets>
Expected<void> check_observations(const std::vector<Observation>& observations, const PoseIds& poses, const Targets& targets,
                                  const char* what) {
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Observation& o = observations[i];
    const auto wrong = [&](const std::string& fault) { return bad_input(fmt::format("{} {} {}", what, i, fault)); };
    if ((o.base != kWorld && !is_among(poses, o.base)) || !is_among(targets, o.target))
      return wrong("names no pose or feature");
    if (!is_valid(o.measured)) return wrong("has a measurement that is not finite, or no rotation");
    auto W = o.information;
    if (const auto fault = InformationCheck().fault(W)) return wrong("has an information matrix that " + *fault);
  }
  return {};
}

template <int Dim>
Expected<void> check_maps(const SubmapSet<Dim>& set) {
  for (std::size_t m = 0; m < set.graph.submaps.size(); ++m) {
    const auto wrong = is_within(set.graph.submaps[m], set) ? fault(set.graph.submaps[m])
                                                            : std::optional<std::string>("names no pose or feature");
    if (wrong) return bad_input(fmt::format("local map {} {}", m + 1, *wrong));
  }
  return {};
}

template <int Dim>
Expected<void> check_fixed(const SubmapSet<Dim>& set) {
  for (const FixedPose<Dim>& fixed : set.graph.fixed) {
    if (!is_among(set.poses, fixed.pose)) return bad_input("a fixed pose is not there");
    if (!is_valid(fixed.value)) return bad_input(to_string(set.poses[fixed.pose]) + " is fixed nowhere");
  }
  return {};
}

}  // namespace

template <int Dim>
Expected<void> check_numbers(const SubmapSet<Dim>& set) {
  const auto checked =
      check_maps(set)
          .and_then([&] { return check_observations(set.graph.pose_factors, set.poses, set.poses, "pose observation"); })
          .and_then(
              [&] { return check_observations(set.graph.feature_factors, set.poses, set.features, "feature observation"); })
          .and_then([&] { return check_fixed(set); });
  return checked ? checked : bad_input(set.source + ": " + checked.error().message);
}

template <int Dim>
Expected<void> check_segments(const SubmapSet<Dim>& set) {
  const auto is_there = [&](const Segment& s) {
    return s.begin <= s.end && is_among(set.poses, s.begin) && is_among(set.poses, s.end);
  };
  if (!std::ranges::all_of(set.segments, is_there)) return bad_input(set.source + ": a segment is of poses that are not there");
  const std::size_t segments = map_segments(set.segments).size();
  if (segments == set.graph.submaps.size()) return {};
  return bad_input(
      fmt::format("{}: {} for {}", set.source, plural(segments, "segment"), plural(set.graph.submaps.size(), "local map")));
}

template Expected<void> check_numbers(const SubmapSet<2>&);
template Expected<void> check_numbers(const SubmapSet<3>&);
template Expected<void> check_segments(const SubmapSet<2>&);
template Expected<void> check_segments(const SubmapSet<3>&);

}  // namespace mapjoin
