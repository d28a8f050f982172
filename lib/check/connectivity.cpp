// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <map>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/check/ties.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <optional>
#include <string>
#include <utility>

namespace mapjoin {
namespace {

/// True if two parts or more have features.
template <typename LogOrSet>
bool do_parts_have_features(const LogOrSet& tied, const std::vector<Edge>& ties) {
  const TieVertices of = vertices_of(tied);
  const std::vector<std::uint32_t> part_of = components_of(make_graph(of.size(), ties));
  const auto is_elsewhere = [&](FeatureIndex f) { return part_of[of.feature(f)] != part_of[of.feature(0)]; };
  return std::ranges::any_of(indices(tied.features), is_elsewhere);
}

/// What ends the sentence of a feature that nothing ties, and that of parts that nothing ties together.
struct Advice {
  std::string unobserved;
  std::string apart;
};

Expected<void> check_tied(const Names& names, const std::vector<Edge>& ties, const Advice& advice) {
  constexpr std::ptrdiff_t kNamed = 3;
  if (names.poses.empty()) return bad_input_of(names.source, "there are no poses");
  const TieVertices of = vertices_of(names);
  const Graph graph = make_graph(of.size(), ties);
  for (const FeatureIndex f : indices(names.features)) {
    if (out_degree(static_cast<Vertex>(of.feature(f)), graph) > 0) continue;
    return bad_input(fmt::format("{}: {} is never observed{}", names.source, to_string(names.features[f]), advice.unobserved));
  }
  std::vector<std::string> roots;
  for (const std::size_t root : component_roots(graph)) roots.push_back(name_of(root, names));
  if (roots.size() <= 1) return {};
  const auto named = roots.begin() + std::min(std::ssize(roots), kNamed);
  return bad_input(fmt::format("{}: nothing ties its {} parts together; they hold {}{}{}", names.source, roots.size(),
                               fmt::join(roots.begin(), named, ", "), named != roots.end() ? ", …" : "", advice.apart));
}

}  // namespace

Expected<void> check_tied(const Names& names, const std::vector<Edge>& ties, const std::string& advice) {
  return check_tied(names, ties, Advice{"", advice});
}

template <typename LogOrSet>
Expected<void> check_connected(const LogOrSet& tied) {
  constexpr bool kIsLog = requires {
    tied.observations();
  };
  if constexpr (kIsLog) {
    if (auto sound = check_invariants(tied); !sound) return sound;
    if (has_values_only(tied)) return bad_input_of(tied.source, kValuesOnly);
  }
  const Names names{tied.source, tied.poses, tied.features};
  const std::vector<Edge> ties = ties_of(tied);
  if (check_tied(names, ties, "")) return {};
  const std::string associate = do_parts_have_features(tied, ties) ? "; --associate ties them by features that they share" : "";
  return check_tied(names, ties,
                    Advice{kIsLog ? "; --parts largest leaves such features out" : "",
                           associate + (kIsLog ? "; --parts largest takes the largest, --parts all makes a map of each" : "")});
}

template <int Dim>
std::vector<Log<Dim>> split_into_parts(const Log<Dim>& log) {
  const TieVertices of = vertices_of(log);
  const std::vector<std::uint32_t> component = components_of(make_graph(of.size(), ties_of(log)));
  std::map<std::uint32_t, LogBuilder<Dim>> builders;  // Numbers of components ascend with their first vertex.
  std::map<std::uint32_t, std::size_t> poses;
  const auto builder = [&](std::size_t vertex) -> LogBuilder<Dim>& {
    return builders.try_emplace(component[vertex], log.source, log.conventions, Numbers::kChecked).first->second;
  };
  for (const PoseIndex p : indices(log.poses)) {
    ++poses[component[of.pose(p)]];
    auto& part = builder(of.pose(p));
    part.add_pose(log.poses[p], log.initial.poses.empty() ? std::nullopt : std::optional(log.initial.poses[p]));
    if (!log.stamps_ns.empty()) part.add_stamp(log.poses[p], log.stamps_ns[p]);
  }
  std::int64_t unobserved = 0;
  for (const FeatureIndex f : indices(log.features)) {
    if (!poses.contains(component[of.feature(f)])) {
      ++unobserved;
      continue;
    }
    builder(of.feature(f))
        .add_feature(log.features[f], log.initial.features.empty() ? std::nullopt : std::optional(log.initial.features[f]));
  }
  const auto base_of = [&](const auto& factor) {
    return factor.base == kWorld ? std::nullopt : std::optional(log.poses[factor.base]);
  };
  for (const auto& factor : log.graph.pose_factors) {
    builder(of.pose(factor.target)).add(base_of(factor), log.poses[factor.target], factor);
  }
  for (const auto& factor : log.graph.feature_factors) {
    if (!poses.contains(component[of.feature(factor.target)])) continue;
    builder(of.feature(factor.target)).add(base_of(factor), log.features[factor.target], factor);
  }
  for (const auto& fixed : log.graph.fixed) builder(of.pose(fixed.pose)).fix(log.poses[fixed.pose], fixed.value);
  std::vector<Log<Dim>> parts;
  for (auto& [number, part] : builders) parts.push_back(std::move(part).finish().value());
  std::ranges::stable_sort(parts, std::greater(), [](const Log<Dim>& part) { return part.poses.size(); });
  if (parts.empty()) return parts;
  parts.front().skipped = log.skipped;
  if (unobserved > 0) parts.front().skipped["features that no pose observes"] = unobserved;
  parts.front().unassociated = log.unassociated;
  return parts;
}

template std::vector<Log<2>> split_into_parts(const Log<2>&);
template std::vector<Log<3>> split_into_parts(const Log<3>&);

template Expected<void> check_connected(const Log<2>&);
template Expected<void> check_connected(const Log<3>&);
template Expected<void> check_connected(const SubmapSet<2>&);
template Expected<void> check_connected(const SubmapSet<3>&);

}  // namespace mapjoin
