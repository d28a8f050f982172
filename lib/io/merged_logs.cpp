// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <map>
#include <mapjoin/io/merged_logs.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

/// The poses of each log by their names.
template <int Dim>
using PoseOf = std::vector<IndexOf<PoseIndex, PoseId>>;

/// The pose that an edge in log `own` means by a name: its own, otherwise that of another log; bad input if none or several
/// have it.
template <int Dim>
Expected<PoseId> meant(const PoseId& name, const NamedEdge<Dim>& edge, std::size_t own, const std::vector<Log<Dim>>& logs,
                       const PoseOf<Dim>& pose_of, const std::vector<std::uint32_t>& first) {
  if (pose_of[own](name)) return PoseId{first[own] + name.session, name.key};
  std::vector<std::size_t> owners;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    if (pose_of[k](name)) owners.push_back(k);
  }
  if (owners.size() == 1) return PoseId{first[owners.front()] + name.session, name.key};
  std::vector<std::string> sources;
  for (const std::size_t k : owners) sources.push_back(logs[k].source);
  const std::string named = fmt::format("{}: the edge from {} to {} names {}", logs[own].source, to_string(edge.base),
                                        to_string(edge.target), to_string(name));
  return bad_input(owners.empty() ? named + ", which no log declares; give the log that does, too, or --skip-undeclared"
                                  : fmt::format("{}, which several other logs declare: {}", named, fmt::join(sources, ", ")));
}

template <int Dim>
bool same_numbers(const NamedEdge<Dim>& a, const Pose<Dim>& measured, const PoseMatrix<Dim>& information) {
  return a.measured == measured && a.information == information;
}

template <int Dim>
std::pair<PoseIndex, PoseIndex> ends_by_index(const PoseFactor<Dim>* edge) {
  return {edge->base, edge->target};
}

/// The edges of a log, by their ends.
template <int Dim>
std::vector<const PoseFactor<Dim>*> edges_by_ends(const Log<Dim>& log) {
  std::vector<const PoseFactor<Dim>*> edges;
  for (const PoseFactor<Dim>& edge : log.edges()) edges.push_back(&edge);
  std::ranges::sort(edges, {}, ends_by_index<Dim>);
  return edges;
}

/// Edges between poses of different logs, or between poses of one log that stand in another.
template <int Dim>
class Ties {
 public:
  Ties(const std::vector<Log<Dim>>& logs, const std::vector<std::uint32_t>& first)
      : logs_(logs), first_(first), own_edges_(logs.size()) {
    for (const Log<Dim>& log : logs) pose_of_.emplace_back(log.poses);
  }

  /// Takes the foreign edges of a log; those that other logs have, too, are only counted unless `keep_copies`.
  Expected<void> take(std::size_t log, bool keep_copies) {
    const std::size_t before = edges_.size();
    for (const NamedEdge<Dim>& foreign : logs_[log].foreign) {
      const auto base = meant<Dim>(foreign.base, foreign, log, logs_, pose_of_, first_);
      const auto target = meant<Dim>(foreign.target, foreign, log, logs_, pose_of_, first_);
      if (!base || !target) return tl::unexpected(base ? target.error() : base.error());
      const NamedEdge<Dim> edge{*base, *target, foreign.measured, foreign.information};
      if (!keep_copies && is_copy(edge, before)) {
        ++copies_;
      } else {
        edges_.push_back(edge);
      }
    }
    for (std::size_t k = before; k < edges_.size(); ++k) known_.emplace(std::pair(edges_[k].base, edges_[k].target), k);
    return {};
  }

  const std::vector<NamedEdge<Dim>>& edges() const { return edges_; }
  std::int64_t copies() const { return copies_; }

 private:
  /// True if a log before this one, or the log of both poses, has the edge.
  bool is_copy(const NamedEdge<Dim>& edge, std::size_t before) {
    const auto [begin, end] = known_.equal_range({edge.base, edge.target});
    for (auto known = begin; known != end; ++known) {
      if (known->second < before && same_numbers(edges_[known->second], edge.measured, edge.information)) return true;
    }
    return is_inside(edge);
  }
  /// True if the log of both poses has the edge.
  bool is_inside(const NamedEdge<Dim>& edge) {
    const auto owner = static_cast<std::size_t>(std::ranges::upper_bound(first_, edge.base.session) - first_.begin() - 1);
    const auto& pose_of = pose_of_[owner];
    const std::uint32_t first = first_[owner];
    if (edge.target.session < first) return false;
    const auto base = pose_of({edge.base.session - first, edge.base.key});
    const auto target = pose_of({edge.target.session - first, edge.target.key});
    if (!base || !target) return false;
    if (!own_edges_[owner]) own_edges_[owner] = edges_by_ends(logs_[owner]);
    const std::pair ends(*base, *target);
    auto own = std::ranges::lower_bound(*own_edges_[owner], ends, {}, ends_by_index<Dim>);
    for (; own != own_edges_[owner]->end() && ends_by_index(*own) == ends; ++own) {
      if (same_numbers(edge, (*own)->measured, (*own)->information)) return true;
    }
    return false;
  }

  const std::vector<Log<Dim>>& logs_;
  const std::vector<std::uint32_t>& first_;
  PoseOf<Dim> pose_of_;
  std::vector<std::optional<std::vector<const PoseFactor<Dim>*>>> own_edges_;  // by their ends, once they are asked for
  std::vector<NamedEdge<Dim>> edges_;
  std::multimap<std::pair<PoseId, PoseId>, std::size_t> known_;
  std::int64_t copies_ = 0;
};

template <int Dim>
bool is_same_map(const LocalMap<Dim>& a, const LocalMap<Dim>& b) {
  return a.base == b.base && a.poses == b.poses && a.features == b.features && a.pose_estimates == b.pose_estimates &&
         a.feature_estimates == b.feature_estimates && a.information.rows() == b.information.rows() &&
         a.information == b.information;
}

template <typename Part>
bool is_copy(const Part& a, const Part& b) {
  return a.poses == b.poses && a.features == b.features && a.graph.pose_factors == b.graph.pose_factors &&
         a.graph.feature_factors == b.graph.feature_factors &&
         std::ranges::equal(a.graph.submaps, b.graph.submaps,
                            [](const auto& one, const auto& other) { return is_same_map(one, other); });
}

/// True if there are more measurements than it takes to place all poses and features relative to the first: two robots hardly
/// agree in what is then redundant.
template <typename Part>
bool is_redundant(const Part& part) {
  std::size_t measured = part.graph.pose_factors.size() + part.graph.feature_factors.size();
  for (const auto& map : part.graph.submaps) measured += map.poses.size() + map.features.size();
  return measured >= part.poses.size() + part.features.size();
}

/// Releases the fixed poses of every log but the one that holds the map: the first with priors, since what they say is of the
/// World, otherwise the first that fixes any; the number of released poses.
template <int Dim>
std::int64_t release_others(std::vector<Log<Dim>>& logs) {
  const auto has_priors = [](const Log<Dim>& log) { return !log.pose_priors().empty() || !log.feature_priors().empty(); };
  const auto fixes_any = [](const Log<Dim>& log) { return !log.graph.fixed.empty(); };
  auto holder = std::ranges::find_if(logs, has_priors);
  if (holder == logs.end()) holder = std::ranges::find_if(logs, fixes_any);
  std::int64_t released = 0;
  for (auto log = logs.begin(); log != logs.end(); ++log) {
    if (log != holder) released += std::ssize(std::exchange(log->graph.fixed, {}));
  }
  return released;
}

/// Removes the time stamps unless every log has them; the number of removed ones.
template <int Dim>
std::int64_t drop_partial_stamps(std::vector<Log<Dim>>& logs) {
  if (std::ranges::none_of(logs, [](const Log<Dim>& log) { return log.stamps_ns.empty(); })) return 0;
  std::int64_t dropped = 0;
  for (Log<Dim>& log : logs) dropped += std::ssize(std::exchange(log.stamps_ns, {}));
  return dropped;
}

/// Removes the initial values of all logs if several have values of one feature, of which each says where it is in its own
/// frame; the number of removed ones.
template <int Dim>
std::int64_t drop_values_of_own_frames(std::vector<Log<Dim>>& logs) {
  FeatureIds valued;
  for (const Log<Dim>& log : logs) {
    if (!log.initial.features.empty()) append(valued, log.features);
  }
  const std::size_t all = valued.size();
  make_distinct(valued);
  if (valued.size() == all) return 0;
  std::int64_t dropped = 0;
  for (Log<Dim>& log : logs) {
    dropped += std::ssize(log.initial.poses) + std::ssize(log.initial.features);
    log.initial = {};
  }
  return dropped;
}

}  // namespace

Expected<Conventions> common_conventions(const std::vector<NamedConventions>& all) {
  Conventions common = all.front().conventions;
  for (std::size_t k = 1; k < all.size(); ++k) {
    const Conventions& next = all[k].conventions;
    if (next.covariance != common.covariance) {
      return bad_input(fmt::format("{} has weights of --covariance {} and {} of --covariance {}: build both with the same",
                                   all.front().source, to_string(common.covariance), all[k].source,
                                   to_string(next.covariance)));
    }
    if (next.inflation != common.inflation) {
      return bad_input(fmt::format("{} and {} have weights of different --inflate: build both with the same",
                                   all.front().source, all[k].source));
    }
    if (next.pose_error != common.pose_error) common.pose_error = PoseError::kPaper;
    if (next.rotation_information != common.rotation_information) common.rotation_information = RotationInformation::kVector;
    common.repairs += next.repairs;
  }
  return common;
}

template <typename Part>
Expected<void> check_no_copies(const std::vector<Part>& parts) {
  for (auto part = parts.begin(); part != parts.end(); ++part) {
    const auto other = std::find_if(parts.begin(), part, [&](const Part& before) { return is_copy(before, *part); });
    if (other == part || !is_redundant(*part)) continue;
    return tl::unexpected(
        Error{ErrorKind::kUsage, fmt::format("{} has the same poses, features and measurements as {}, number by number, "
                                             "which would count twice: leave one out; --keep-copies takes both for robots",
                                             part->source, other->source)});
  }
  return {};
}

Expected<std::uint64_t> step_apart(std::uint64_t largest, std::size_t parts) {
  std::uint64_t step = 1;
  const std::uint64_t most = std::numeric_limits<std::uint64_t>::max() / parts;
  while (step <= largest && step <= most / 10) step *= 10;
  if (step > largest) return step;
  return tl::unexpected(Error{ErrorKind::kUsage, "the ids of features are too large to number those of several inputs apart"});
}

template <int Dim>
Expected<Log<Dim>> merged(std::vector<Log<Dim>> logs, const MergeOptions& options) {
  if (logs.empty()) throw std::invalid_argument("no logs to be merged");
  for (const Log<Dim>& log : logs) {
    if (auto sound = check_invariants(log); !sound) return tl::unexpected(sound.error());
  }
  if (logs.size() == 1) return std::move(logs.front());
  if (auto once = options.keep_copies ? Expected<void>() : check_no_copies(logs); !once) return tl::unexpected(once.error());
  if (auto apart = options.own_features ? number_features_apart(logs) : Expected<void>(); !apart)
    return tl::unexpected(apart.error());
  std::vector<NamedConventions> named;
  for (const Log<Dim>& log : logs) named.push_back({log.source, log.conventions});
  const auto conventions = common_conventions(named);
  if (!conventions) return tl::unexpected(conventions.error());
  const std::int64_t released = release_others(logs);
  const std::int64_t stamps = drop_partial_stamps(logs);
  const std::int64_t values = drop_values_of_own_frames(logs);
  const auto sessions = first_sessions(logs);
  if (!sessions) return tl::unexpected(sessions.error());
  const std::vector<std::uint32_t>& first = *sessions;
  Ties<Dim> ties(logs, first);
  std::vector<std::string> sources;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    if (auto taken = ties.take(k, options.keep_copies); !taken) return tl::unexpected(taken.error());
    sources.push_back(logs[k].source);
  }
  LogBuilder<Dim> builder(fmt::format("{}", fmt::join(sources, " + ")), without_repairs(*conventions), Numbers::kChecked);
  for (std::size_t k = 0; k < logs.size(); ++k) builder.append(logs[k], first[k]);
  for (const NamedEdge<Dim>& edge : ties.edges()) {
    builder.add_pose_edge(edge.base, edge.target, edge.measured, edge.information);
  }
  if (ties.copies() > 0) builder.add_skipped("copies of edges in another file", ties.copies());
  if (released > 0) builder.add_skipped("fixed poses of other files", released);
  if (stamps > 0) builder.add_skipped("time stamps that other files lack", stamps);
  if (values > 0) builder.add_skipped("initial values, each in the frame of its file", values);
  return std::move(builder).finish();
}

#define MAPJOIN_INSTANTIATE(Dim)                                               \
  template Expected<void> check_no_copies(const std::vector<Log<Dim>>&);       \
  template Expected<void> check_no_copies(const std::vector<SubmapSet<Dim>>&); \
  template Expected<Log<Dim>> merged(std::vector<Log<Dim>>, const MergeOptions&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
