// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mapjoin/check/checks.hpp>
#include <mapjoin/check/ties.hpp>
#include <mapjoin/check/weak_links.hpp>
#include <mapjoin/model/lists.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The number of ties of each feature: its observations, priors and maps.
template <typename Tied>
Table<FeatureIndex, std::size_t> times_seen(const Tied& tied) {
  const TieVertices of = vertices_of(tied);
  Table<FeatureIndex, std::size_t> times(of.features);
  for_each_tie(tied, [&](std::size_t, std::size_t b) {
    if (of.is_feature(b)) ++times[of.feature_at(b)];
  });
  return times;
}

template <typename Tied>
Places features_seen(std::size_t wanted, const Table<FeatureIndex, std::size_t>& times, const Tied& tied) {
  Places places;
  for (const FeatureIndex f : indices(times)) {
    if (times[f] == wanted) places.add(to_string(tied.features[f]));
  }
  return places;
}

template <typename Tied>
void check_features(const Tied& tied, Findings& findings) {
  constexpr bool kIsLog = requires {
    tied.observations();
  };
  constexpr std::size_t kEnoughToJudge = 20;
  const Table<FeatureIndex, std::size_t> times = times_seen(tied);
  const Places never = features_seen(0, times, tied);
  add_if_any(findings, {FindingLevel::kError, "unobserved",
                        fmt::format("declared, but never observed: {} of {} features", never.count, times.size()), never});
  const Places once = features_seen(1, times, tied);
  const char* const what =
      kIsLog ? "seen once only, which adds nothing to the map" : "in one map only, which ties it to no other";
  const bool is_most = kIsLog && times.size() >= kEnoughToJudge && 2 * once.count > times.size();
  add_if_any(findings, {is_most ? FindingLevel::kWarning : FindingLevel::kNote, "seen_once",
                        fmt::format("{}: {} of {} features{}", what, once.count, times.size(),
                                    is_most ? "; does each have one id whenever it is seen?" : ""),
                        once});
}

template <typename Tied>
void check_parts(const Tied& tied, Findings& findings) {
  Places parts;
  const Graph graph = make_graph(vertices_of(tied).size(), ties_of(tied));
  for (const std::size_t v : component_roots(graph)) {
    const bool is_unobserved = vertices_of(tied).is_feature(v) && out_degree(static_cast<Vertex>(v), graph) == 0;
    if (!is_unobserved) parts.add(name_of(v, tied));
  }
  if (parts.count < 2) return;
  findings.push_back({FindingLevel::kError, "parts", fmt::format("nothing ties {} parts together", parts.count), parts});
}

template <typename Tied>
void check_links(const Tied& tied, Findings& findings) {
  const WeakLinks links = weak_links(tied);
  Places chains;
  for (const LoneChain& chain : links.chains) {
    const std::string ends = fmt::format("{} to {}", name_of(chain.first, tied), name_of(chain.last, tied));
    chains.add(chain.edges == 1 ? ends : fmt::format("{} ({} edges in a row)", ends, chain.edges));
  }
  add_if_any(findings, {FindingLevel::kWarning, "weak_link",
                        fmt::format("{} where a single edge holds two parts together: an error in it shows nowhere",
                                    plural(chains.count, "place")),
                        chains});
  Places features;
  for (const std::size_t v : links.features) features.add(name_of(v, tied));
  add_if_any(findings, {FindingLevel::kWarning, "weak_feature",
                        fmt::format("{} without which poses fall apart: what hangs on one can turn about it",
                                    plural(features.count, "feature")),
                        features});
}

/// The number of features that each body, a group of poses tied by edges (its number in `body_of`), shares with others.
template <typename Tied>
std::map<std::uint32_t, std::size_t> shared_features(const Tied& tied, const std::vector<std::uint32_t>& body_of) {
  const TieVertices of = vertices_of(tied);
  std::vector<std::pair<std::size_t, std::uint32_t>> seen;  // Feature, body.
  for_each_tie(tied, [&](std::size_t a, std::size_t b) {
    if (of.is_feature(b)) seen.emplace_back(b, body_of[a]);
  });
  make_distinct(seen);
  std::map<std::uint32_t, std::size_t> shared;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const bool is_shared =
        (i > 0 && seen[i - 1].first == seen[i].first) || (i + 1 < seen.size() && seen[i + 1].first == seen[i].first);
    if (is_shared) ++shared[seen[i].second];
  }
  return shared;
}

/// Finds the bodies that too few features hold, or just enough. One that shares no feature is a part of its own (check_parts).
template <int Dim, typename Tied>
void check_bodies(const Tied& tied, Findings& findings) {
  const TieVertices of = vertices_of(tied);
  std::vector<Edge> between_poses = ties_of(tied);
  std::erase_if(between_poses, [&](const Edge& tie) { return of.is_feature(tie.second); });
  const std::vector<std::uint32_t> body_of = components_of(make_graph(of.size(), between_poses));
  std::map<std::uint32_t, std::size_t> first_of;
  for (std::size_t v = 0; v < body_of.size(); ++v) first_of.try_emplace(body_of[v], v);
  Places loose;
  Places weak;
  for (const auto& [body, count] : shared_features(tied, body_of)) {
    if (count > Dim) continue;
    (count < Dim ? loose : weak)
        .add(fmt::format("the poses with {}: {} shared", name_of(first_of.at(body), tied), plural(count, "feature")));
  }
  add_if_any(findings, {FindingLevel::kError, "loose_body",
                        fmt::format("{} of poses held to the others by fewer than {} features: that leaves them free to turn",
                                    plural(loose.count, "group"), Dim),
                        loose});
  add_if_any(findings, {FindingLevel::kWarning, "weak_body",
                        fmt::format("{} of poses held to the others by {} features, with not one to spare",
                                    plural(weak.count, "group"), Dim),
                        weak});
}

template <int Dim, typename Tied>
Findings check_ties(const Tied& tied) {
  Findings findings;
  check_parts(tied, findings);
  check_bodies<Dim>(tied, findings);
  check_links(tied, findings);
  check_features(tied, findings);
  return findings;
}

template <int Dim>
void check_stamps(const Log<Dim>& log, Findings& findings) {
  if (log.stamps_ns.empty()) return;
  Places places;
  for (const Session& session : log.sessions) {
    for (PoseIndex p = session.begin + 1; p < session.end; ++p) {
      if (log.stamps_ns[p] <= log.stamps_ns[p - 1]) places.add(to_string(log.poses[p]));
    }
  }
  add_if_any(findings, {FindingLevel::kWarning, "stamps",
                        fmt::format("{} no later than the pose driven before: are the times those of these ids?",
                                    plural(places.count, "pose is", "poses are")),
                        places});
}

}  // namespace

std::size_t StepCounts::driven_twice() const {
  constexpr std::size_t kLeast = 10;  // Fewer prove nothing.
  return repeated >= kLeast && 2 * repeated > all ? repeated : 0;
}

template <int Dim>
StepCounts count_steps(const Log<Dim>& log) {
  StepCounts counts;
  const auto odometry = log.odometry();
  for (auto edge = odometry.begin(); edge != odometry.end(); ++counts.all) {
    const auto next =
        std::find_if(edge, odometry.end(), [&](const auto& other) { return later_pose(other) != later_pose(*edge); });
    if (next - edge > 1) ++counts.repeated;
    edge = next;
  }
  return counts;
}

std::string repeated_steps_in_words(std::size_t steps) {
  return fmt::format("{} several edges, which all count: two sensors? Two logs in one file are to be given as two files",
                     plural(steps, "step of odometry has", "steps of odometry have"));
}

template <int Dim>
Findings check_structure(const Log<Dim>& log) {
  if (const auto sound = check_invariants(log); !sound) return {{FindingLevel::kError, "unsound", sound.error().message, {}}};
  if (has_values_only(log)) return {{FindingLevel::kError, "parts", kValuesOnly, {}}};
  Findings findings = check_ties<Dim>(log);
  check_stamps(log, findings);
  Places breaks;
  for (std::size_t s = 1; s < log.sessions.size(); ++s) {
    const PoseId& before = log.poses[log.sessions[s].begin - 1];
    const PoseId& after = log.poses[log.sessions[s].begin];
    if (before.session == after.session) breaks.add(fmt::format("{} to {}", to_string(before), to_string(after)));
  }
  add_if_any(findings,
             {FindingLevel::kNote, "breaks",
              fmt::format("{} without odometry: a session of its own begins behind it", plural(breaks.count, "step")), breaks});
  const std::size_t twice = count_steps(log).driven_twice();
  add_if_any(findings, {FindingLevel::kWarning, "driven_twice", repeated_steps_in_words(twice), {twice, {}}});
  const auto unassociated = static_cast<std::size_t>(log.unassociated);
  add_if_any(findings, {FindingLevel::kNote,
                        "unassociated",
                        fmt::format("{} left out: the file does not say of which feature", plural(unassociated, "observation")),
                        {unassociated, {}}});
  return findings;
}

template <int Dim>
Findings check_structure(const SubmapSet<Dim>& set) {
  return check_ties<Dim>(set);
}

template StepCounts count_steps(const Log<2>&);
template StepCounts count_steps(const Log<3>&);
template Findings check_structure(const Log<2>&);
template Findings check_structure(const Log<3>&);
template Findings check_structure(const SubmapSet<2>&);
template Findings check_structure(const SubmapSet<3>&);

}  // namespace mapjoin
