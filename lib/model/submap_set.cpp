// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/model/faults.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

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

/// The fault of a map that has a pose, its base included, or a feature twice; nullopt if none.
template <int Dim>
std::optional<std::string> named_twice(const LocalMap<Dim>& map, const SubmapSet<Dim>& set) {
  std::vector<PoseIndex> poses = map.poses;
  poses.push_back(map.base);
  if (const auto pose = repeated(poses)) return "has " + to_string(set.poses[*pose]) + " twice";
  if (const auto feature = repeated(map.features)) return "has " + to_string(set.features[*feature]) + " twice";
  return std::nullopt;
}

/// The fault of a map of the set; nullopt if none.
template <int Dim>
std::optional<std::string> fault(const LocalMap<Dim>& map, const SubmapSet<Dim>& set) {
  if (!is_within(map, set)) return "names a pose or feature that is not there";
  if (auto twice = named_twice(map, set)) return twice;
  return fault(map);
}

template <int Dim>
Expected<void> check_maps(const SubmapSet<Dim>& set) {
  for (std::size_t m = 0; m < set.graph.submaps.size(); ++m) {
    if (const auto wrong = fault(set.graph.submaps[m], set)) return bad_input(fmt::format("local map {} {}", m + 1, *wrong));
  }
  return {};
}

template <int Dim>
Expected<void> check_fixed(const SubmapSet<Dim>& set) {
  for (const FixedPose<Dim>& fixed : set.graph.fixed) {
    if (!is_among(set.poses, fixed.pose)) return bad_input("a fixed pose is not there");
    if (!is_valid(fixed.value))
      return bad_input(to_string(set.poses[fixed.pose]) + " is fixed at a value that is not finite, or no rotation");
  }
  return fixed_once(set.graph.fixed, set.poses).map([](const auto&) {});
}

}  // namespace

template <int Dim>
Expected<void> check_content(const SubmapSet<Dim>& set) {
  const auto checked =
      check_names(set.poses)
          .and_then([&] { return check_names(set.features); })
          .and_then([&] { return check_maps(set); })
          .and_then([&] { return check_factors("pose factor", set.graph.pose_factors, set.poses, set.poses); })
          .and_then([&] { return check_factors("feature factor", set.graph.feature_factors, set.poses, set.features); })
          .and_then([&] { return check_fixed(set); });
  return checked ? checked : bad_input_of(set.source, checked.error().message);
}

template <int Dim>
bool keeps_all_of(const LocalMap<Dim>& map, const Segment& segment) {
  std::vector<PoseIndex> behind_base(static_cast<std::size_t>(segment.end - segment.begin));
  std::iota(behind_base.begin(), behind_base.end(), segment.begin + 1);
  return map.base == segment.begin && map.poses == behind_base;
}

template <int Dim>
Expected<void> check_segments(const SubmapSet<Dim>& set) {
  if (set.poses.empty()) return bad_input_of(set.source, "there are no poses");
  const std::size_t segments = map_segments(set.segments).size();
  if (segments != set.graph.submaps.size()) {
    return bad_input_of(set.source, plural(segments, "segment") + " for " + plural(set.graph.submaps.size(), "local map"));
  }
  const auto wrong = [&](PoseIndex pose, const char* what) {
    return bad_input_of(set.source, to_string(set.poses[pose]) + what);
  };
  PoseIndex next = 0;
  auto map = set.graph.submaps.begin();
  for (const Segment& s : set.segments) {
    if (!is_among(set.poses, s.begin) || !is_among(set.poses, s.end) || s.end < s.begin) {
      return bad_input_of(set.source, fmt::format("segment {} is of poses that are not there", &s - set.segments.data() + 1));
    }
    if (s.begin > next) return wrong(next, " is in no segment");
    if (s.begin + 1 < next) return wrong(s.begin, " begins a segment, but is within the one before");
    if (s.is_map && !keeps_all_of(*map++, s))
      return wrong(s.begin, " begins a segment, but not a local map of all its poses in their order");
    next = s.end + 1;
  }
  return is_among(set.poses, next) ? wrong(next, " is in no segment") : Expected<void>();
}

template bool keeps_all_of(const LocalMap<2>&, const Segment&);
template bool keeps_all_of(const LocalMap<3>&, const Segment&);
template Expected<void> check_content(const SubmapSet<2>&);
template Expected<void> check_content(const SubmapSet<3>&);
template Expected<void> check_segments(const SubmapSet<2>&);
template Expected<void> check_segments(const SubmapSet<3>&);

}  // namespace mapjoin
