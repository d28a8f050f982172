// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/join/study/comparison.hpp>
#include <mapjoin/join/study/truth_errors.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <stdexcept>
#include <utility>

namespace mapjoin {
namespace {

std::size_t poses_of(const Session& session) {
  return session.end.position() - session.begin.position();
}

/// The spans that are shorter than the longest session.
std::vector<std::size_t> spans_within(const PoseIds& ids) {
  std::size_t poses = 0;
  for (const Session& session : sessions_by_name(ids)) poses = std::max(poses, poses_of(session));
  std::vector<std::size_t> spans;
  for (std::size_t power = 1; power < poses; power *= 10) {
    for (const std::size_t factor : {1U, 2U, 5U}) {
      if (factor * power < poses) spans.push_back(factor * power);
    }
  }
  return spans;
}

/// The relative errors over each span, `error_of` the pairs of poses of one session that are so many steps apart.
template <typename ErrorOf>
std::vector<PoseErrorSummary> span_errors(const PoseIds& ids, const std::vector<std::size_t>& spans, const ErrorOf& error_of) {
  std::vector<PoseErrorSummary> errors;
  for (const std::size_t span : spans) {
    errors.push_back(
        error_of(pairs_within_sessions(ids, [&](const Session& session) { return pairs_by_steps(poses_of(session), span); })));
  }
  return errors;
}

template <int Dim>
RunOptions run_options(const ComparedCase& way, const ComparisonOptions<Dim>& options) {
  RunOptions run = without_verdict();
  run.split = {SplitRule::kPoses, static_cast<double>(way.poses_per_map)};
  run.schedule = way.schedule;
  run.state = way.state;
  run.gradual = way.gradual;
  run.solver = options.solver;
  run.keep_recovered = true;
  return run;
}

template <int Dim>
Expected<RunResult<Dim>> map_by(const Log<Dim>& log, const ComparedCase& way, const ComparisonOptions<Dim>& options,
                                const std::stop_token& stop) {
  const std::size_t maps = log.poses.size() / static_cast<std::size_t>(way.poses_per_map);
  if (rule_of(way.schedule).is_map_by_map() && maps > options.most_sequential) {
    return bad_input(fmt::format("not tried: about {} maps one by one take too long", maps));
  }
  const RunOptions run_as = run_options(way, options);
  return way.is_full_slam() ? solve(log, run_as, stop) : run(log, run_as, stop);
}

/// Runs a case and keeps its maps.
template <int Dim>
Expected<CaseFigures> take(const Log<Dim>& log, const ComparedCase& way, const ComparisonOptions<Dim>& options,
                           const std::stop_token& stop, CaseMaps<Dim>& maps) {
  CaseFigures figures;
  figures.way = way;
  const EffortMeter meter;
  auto result = map_by(log, way, options, stop);
  figures.effort = meter.so_far();
  if (stop.stop_requested()) return interrupted("comparing");
  if (!result) {
    figures.failure = result.error().message;
    return figures;
  }
  figures.run = static_cast<const RunFigures&>(*result);
  figures.joined.chi2 = result->recovered_chi2.value_or(result->chi2);
  figures.polished.chi2 = result->chi2;
  maps.joined = maps.polished = std::move(result->map);
  maps.joined.poses = std::move(result->recovered->poses);
  maps.joined.features = std::move(result->recovered->features);
  return figures;
}

/// The case of least chi2; nullopt if no case gives a map.
std::optional<std::size_t> least_chi2(const std::vector<CaseFigures>& cases) {
  std::optional<std::size_t> best;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    if (!cases[k].has_map()) continue;
    if (!best || cases[k].polished.chi2 < cases[*best].polished.chi2) best = k;
  }
  return best;
}

/// Fills in the differences of an estimate from the best one and from the truth.
template <int Dim>
void measure(const GlobalMap<Dim>& map, const GlobalMap<Dim>& best, const std::vector<std::size_t>& spans,
             const Truth<Dim>* truth, EstimateFigures& figures) {
  figures.from_best = map_difference(map, best);
  figures.best_spans = span_errors(map.pose_ids, spans,
                                   [&](const PosePairs& pairs) { return relative_pose_error(map.poses, best.poses, pairs); });
  if (!truth) return;
  figures.from_truth = TruthDistance{
      absolute_errors(map, *truth).poses,
      span_errors(map.pose_ids, spans, [&](const PosePairs& pairs) { return relative_errors(map, *truth, pairs); })};
}

}  // namespace

std::string schedule_in_words(const ComparedCase& way) {
  return (way.gradual ? "gradual " : "") + to_string(way.schedule);
}

std::string to_string(const ComparedCase& way) {
  const std::string maps = way.is_full_slam() ? "" : fmt::format(", maps of {} steps", way.poses_per_map);
  return fmt::format("{}{}, {}", to_string(way.formulation()), maps, schedule_in_words(way));
}

std::vector<ComparedCase> compared_cases(const std::vector<int>& poses_per_map) {
  std::vector<ComparedCase> cases;
  const auto add = [&](int steps, std::initializer_list<Schedule> schedules) {
    for (const JoinedState state : {JoinedState::kAbsolute, JoinedState::kRelative}) {
      for (const Schedule schedule : schedules) cases.push_back({steps, state, schedule, false});
    }
    cases.push_back({steps, JoinedState::kRelative, Schedule::kBatch, true});
  };
  add(1, {Schedule::kAligned, Schedule::kTree, Schedule::kBatch});
  for (const int steps : poses_per_map)
    add(steps, {Schedule::kAligned, Schedule::kTree, Schedule::kSequential, Schedule::kBatch});
  return cases;
}

template <int Dim>
Expected<Comparison<Dim>> compare(const Log<Dim>& log, const ComparisonOptions<Dim>& options, const std::stop_token& stop) {
  if (auto connected = check_connected(log); !connected) return tl::unexpected(connected.error());
  if (options.cases.empty()) throw std::invalid_argument("there is no case to compare");
  for (const ComparedCase& way : options.cases) {
    if (way.poses_per_map < 1) throw std::invalid_argument("a local map has at least one step");
  }
  Comparison<Dim> comparison;
  for (const ComparedCase& way : options.cases) {
    if (options.progress) options.progress(comparison.cases.size());
    auto figures = take(log, way, options, stop, comparison.maps.emplace_back());
    if (!figures) return tl::unexpected(figures.error());
    comparison.cases.push_back(*std::move(figures));
  }
  const auto best = least_chi2(comparison.cases);
  if (!best) return bad_input("no case gives a map; the first: " + comparison.cases.front().failure);
  comparison.best = *best;
  comparison.spans = spans_within(log.poses);
  const GlobalMap<Dim>& best_map = comparison.maps[*best].polished;
  const double least = comparison.cases[*best].polished.chi2;
  for (std::size_t k = 0; k < comparison.cases.size(); ++k) {
    CaseFigures& figures = comparison.cases[k];
    if (!figures.has_map()) continue;
    figures.reaches_best = figures.run.converged() && is_same_chi2(figures.polished.chi2, least);
    measure(comparison.maps[k].joined, best_map, comparison.spans, options.truth, figures.joined);
    measure(comparison.maps[k].polished, best_map, comparison.spans, options.truth, figures.polished);
  }
  return comparison;
}

#define MAPJOIN_INSTANTIATE(Dim) \
  template Expected<Comparison<Dim>> compare(const Log<Dim>&, const ComparisonOptions<Dim>&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
