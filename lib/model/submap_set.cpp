// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/submap_set.hpp>

namespace mapjoin {
namespace {

bool is_index(Index index, std::size_t size) {
  return index >= 0 && static_cast<std::size_t>(index) < size;
}

template <int Dim>
bool is_within(const LocalMap<Dim>& map, const SubmapSet<Dim>& set) {
  const auto among = [](const std::vector<Index>& indices, std::size_t size) {
    return std::all_of(indices.begin(), indices.end(), [size](Index index) { return is_index(index, size); });
  };
  return is_index(map.base, set.poses.size()) && among(map.poses, set.poses.size()) && among(map.features, set.features.size());
}

template <typename Observation>
Expected<void> check_observations(const std::vector<Observation>& observations, std::size_t poses, std::size_t targets,
                                  const char* what) {
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Observation& o = observations[i];
    const auto wrong = [&](const std::string& fault) { return bad_input(fmt::format("{} {} {}", what, i, fault)); };
    if ((o.base != kWorld && !is_index(o.base, poses)) || !is_index(o.target, targets))
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
    if (!is_index(fixed.pose, set.poses.size())) return bad_input("a fixed pose is not there");
    if (!is_valid(fixed.value))
      return bad_input(to_string(set.poses[static_cast<std::size_t>(fixed.pose)]) + " is fixed nowhere");
  }
  return {};
}

}  // namespace

template <int Dim>
Expected<void> check_numbers(const SubmapSet<Dim>& set) {
  const std::size_t poses = set.poses.size();
  const auto checked =
      check_maps(set)
          .and_then([&] { return check_observations(set.graph.pose_factors, poses, poses, "pose observation"); })
          .and_then(
              [&] { return check_observations(set.graph.feature_factors, poses, set.features.size(), "feature observation"); })
          .and_then([&] { return check_fixed(set); });
  return checked ? checked : bad_input(set.source + ": " + checked.error().message);
}

template Expected<void> check_numbers(const SubmapSet<2>&);
template Expected<void> check_numbers(const SubmapSet<3>&);

}  // namespace mapjoin
