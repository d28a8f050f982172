// SPDX-License-Identifier: BSD-3-Clause
#include <sys/resource.h>

#include <algorithm>
#include <apps/report/run_report.hpp>
#include <mapjoin/check/checks.hpp>
#include <mapjoin/measure/effort.hpp>
#include <set>
#include <utility>

namespace mapjoin::apps {
namespace {

NamedMisfit named(const Misfit& misfit, const PoseIds& poses, const FeatureIds& features) {
  NamedMisfit name{misfit, std::nullopt, PoseId()};
  if (misfit.from != kWorld) name.from = poses[misfit.from];
  if (const auto* pose = std::get_if<PoseIndex>(&misfit.to)) {
    name.to = poses[*pose];
  } else {
    name.to = features[std::get<FeatureIndex>(misfit.to)];
  }
  return name;
}

std::vector<std::size_t> lines_at(const GpsReport& gps, const PoseId& pose) {
  std::vector<std::size_t> lines;
  const auto [begin, end] = gps.lines.equal_range(pose);
  std::transform(begin, end, std::back_inserter(lines), [](const auto& fix) { return fix.second; });
  return lines;
}

/// The number of sessions that the names tell apart, those of several inputs, also in one store.
std::size_t named_sessions(const PoseIds& poses) {
  std::set<std::uint32_t> sessions;
  for (const PoseId& id : poses) sessions.insert(id.session);
  return sessions.size();
}

/// The number of features that poses of several sessions see.
template <int Dim>
std::size_t shared_features(const Log<Dim>& log) {
  Table<FeatureIndex, std::set<std::uint32_t>> sessions(log.features.size());
  for (const auto& seen : log.observations()) sessions[seen.target].insert(log.poses[seen.base].session);
  return static_cast<std::size_t>(std::ranges::count_if(sessions, [](const auto& of) { return of.size() > 1; }));
}

}  // namespace

RunReport::RunReport(std::string command_name, const Options& given)
    : command(std::move(command_name)), input(given.input.string()), options(given.run) {
  has_several_inputs = !given.further.empty();
  if (!given.gps.empty()) gps = GpsReport{given.gps.string(), given.of_gps.lever, {}, 0, 0, {}, {}};
  for (const auto& further : given.further) input += " + " + further.string();
}

template <int Dim>
void RunReport::describe(const Log<Dim>& log) {
  dimension = Dim;
  conventions = log.conventions;
  has_stamps = !log.stamps_ns.empty();
  counts = {.sessions = log.sessions.size(),
            .poses = log.poses.size(),
            .features = log.features.size(),
            .odometry = log.odometry().size(),
            .closures = log.closures().size(),
            .observations = log.observations().size(),
            .priors = log.pose_priors().size() + log.feature_priors().size(),
            .fixed_poses = log.graph.fixed.size(),
            .repeated_edges = log.repeated_edges,
            .unassociated = log.unassociated,
            .skipped = log.skipped,
            .repeated_steps = count_steps(log).driven_twice(),
            .shared_features = has_several_inputs ? shared_features(log) : 0};
}

template <int Dim>
void RunReport::describe(const SubmapSet<Dim>& set) {
  dimension = Dim;
  conventions = set.conventions;
  counts = {.sessions = named_sessions(set.poses),
            .poses = set.poses.size(),
            .features = set.features.size(),
            .observations = set.graph.feature_factors.size(),
            .fixed_poses = set.graph.fixed.size()};
  for (const LocalMap<Dim>& map : set.graph.submaps) counts.map_features += map.features.size();
  has_several_inputs |= counts.sessions > 1;
  features_are_shared = set.features_are_shared;
  has_local_maps = true;
  figures.local_maps = set.graph.submaps.size();
}

template <int Dim>
void RunReport::describe(const StoredMaps<Dim>& stored) {
  has_several_inputs |= named_sessions(stored.log.poses) > 1;
  features_are_shared = stored.features_are_shared;
  describe(stored.log);
  has_local_maps = true;
  figures.local_maps = stored.maps.size();
  figures.raw_segments = stored.segments.size() - stored.maps.size();
}

template <typename Input>
void RunReport::describe(const Input& input, const std::vector<Rejected>& left_out) {
  for (const Rejected& one : left_out) rejected.push_back({named(one.misfit, input.poses, input.features), one.why});
}

template <int Dim>
void RunReport::describe(const Log<Dim>& log, const AttachedFixes& attached, const std::vector<RejectedFix>& left_out) {
  counts.priors = attached.lines.size();
  counts.fixed_poses = log.graph.fixed.size();
  counts.skipped = log.skipped;
  gps->frame = attached.frame;
  gps->fixes = attached.lines.size();
  gps->left_out = attached.left_out;
  const auto pose_of = [&](std::size_t prior) { return log.poses[log.pose_priors()[prior].target]; };
  for (const RejectedFix& fix : left_out) gps->rejected.push_back({attached.lines[fix.prior], pose_of(fix.prior), fix});
  for (std::size_t prior = 0; prior < attached.lines.size(); ++prior) {
    const bool is_left_out = std::ranges::binary_search(left_out, prior, {}, &RejectedFix::prior);
    if (!is_left_out) gps->lines.emplace(pose_of(prior), attached.lines[prior]);
  }
}

template <int Dim>
void RunReport::describe(const RunResult<Dim>& result) {
  figures = static_cast<const RunFigures&>(result);
  options.schedule = result.join.schedule;
  has_local_maps = is_joined = true;
  const auto& ids = result.map.pose_ids;
  for (const PoseIndex pose : result.map.gauge) anchored.push_back(ids[pose]);
  for (const Misfit& misfit : result.fit.misfits) {
    misfits.push_back(named(misfit, ids, result.map.feature_ids));
    if (gps && misfit.kind == PartKind::kPrior) misfits.back().lines = lines_at(*gps, std::get<PoseId>(misfits.back().to));
  }
  for (const MapFit& fit : result.maps) {
    map_bases.push_back(ids[fit.base]);
    map_ends.push_back(ids[fit.end]);
  }
}

std::vector<std::pair<std::string, double>> RunReport::stages() const {
  const RunSeconds& seconds = figures.seconds;
  return {{"read", read_seconds},       {"associate", association_seconds},
          {"reject", robust_seconds},   {"build", seconds.build},
          {"join", seconds.join},       {"recover", seconds.recover},
          {"polish", seconds.polish},   {"covariances", seconds.covariances},
          {"verdict", seconds.verdict}, {"write", write_seconds}};
}

double peak_memory_mb() {
  // getrusage() inherits the peak of the process that started this one, so the one that Linux keeps per program comes first.
  if (const auto bytes = largest_resident_memory()) return 1e-6 * static_cast<double>(*bytes);
  ::rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024e-6;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                             \
  template void RunReport::describe(const Log<Dim>&);                                                        \
  template void RunReport::describe(const SubmapSet<Dim>&);                                                  \
  template void RunReport::describe(const StoredMaps<Dim>&);                                                 \
  template void RunReport::describe(const Log<Dim>&, const std::vector<Rejected>&);                          \
  template void RunReport::describe(const SubmapSet<Dim>&, const std::vector<Rejected>&);                    \
  template void RunReport::describe(const Log<Dim>&, const AttachedFixes&, const std::vector<RejectedFix>&); \
  template void RunReport::describe(const RunResult<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
