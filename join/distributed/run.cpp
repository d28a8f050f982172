// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/distributed/region_problem.hpp>
#include <mapjoin/distributed/run.hpp>
#include <mapjoin/join/settled.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/solve/minimise.hpp>
#include <optional>
#include <utility>

namespace mapjoin::distributed {
namespace {

template <int Dim>
Expected<void> check_room(const Communicator& comm, const RegionProblem<Dim>& problem, double most_megabytes) {
  const double fronts = comm.max(static_cast<double>(problem.solver().bytes()) / 1e6);
  const double separators = problem.solver().interface_megabytes();
  if (most_megabytes <= 0.0 || fronts + separators <= most_megabytes) return {};
  return tl::unexpected(Error{
      ErrorKind::kTooLarge,
      fmt::format("a rank's factor would take {:.0f} MB and its part of what regions share {:.0f} MB, more than the {:.0f} "
                  "MB of --max-memory; take more ranks, or --out-of-core for the latter",
                  fronts, separators, most_megabytes)});
}

/// What cannot be determined, by name, where it is of this rank.
template <int Dim>
Expected<void> check_determined(const LogPart<Dim>& whole, const Region<Dim>& region, const RegionProblem<Dim>& problem,
                                const MinimiseResult& result) {
  if (result.status != MinimiseStatus::kSingular || !problem.solver().is_singular_here()) return {};
  const PoseOrFeature place = problem.system().place_of_variable(*result.singular);
  if (const auto* pose = std::get_if<PoseIndex>(&place)) {
    return bad_input(to_string(whole.poses[region.partial.poses[*pose]]) + " cannot be determined");
  }
  return bad_input(to_string(whole.features[region.partial.features[std::get<FeatureIndex>(place)]]) + " cannot be determined");
}

/// Measured rows of the factors of a region.
template <int Dim>
std::int64_t measured_rows(const Region<Dim>& region) {
  std::int64_t rows = 0;
  for (const auto& o : region.graph.pose_factors) rows += information_rank(o.information);
  for (const auto& o : region.graph.feature_factors) rows += information_rank(o.information);
  return rows;
}

/// The map on the first rank: what several regions have is of the first of them.
template <int Dim>
GlobalMap<Dim> gathered(const Communicator& comm, const LogPart<Dim>& whole, const Region<Dim>& region,
                        const Values<Dim>& estimate) {
  std::vector<PoseIndex> anchored;
  for (const PoseIndex place : region.gauge.anchored) anchored.push_back(region.partial.poses[place]);
  anchored = comm.gather(anchored);
  std::vector<std::string> to(static_cast<std::size_t>(comm.size()));
  to.front() =
      Writer().put(region.partial.poses).put(estimate.poses).put(region.partial.features).put(estimate.features).bytes();
  std::vector<std::string> from = comm.exchange(std::move(to));
  GlobalMap<Dim> map;
  if (!comm.is_root()) return map;
  std::ranges::sort(anchored);
  anchored.erase(std::unique(anchored.begin(), anchored.end()), anchored.end());
  map.gauge = std::move(anchored);
  map.pose_ids = whole.poses;
  map.feature_ids = whole.features;
  map.conventions = whole.conventions;
  map.poses.resize(whole.poses.size());
  map.features.resize(whole.features.size(), Point<Dim>::Zero());
  for (std::string& message : from) {
    Reader reader(message);
    const auto poses = reader.template take<PoseIndex>();
    const auto pose_values = reader.template take<Pose<Dim>>();
    for (std::size_t k = 0; k < poses.size(); ++k) map.poses[poses[k]] = pose_values[k];
    const auto features = reader.template take<FeatureIndex>();
    const auto feature_values = reader.template take<Point<Dim>>();
    for (std::size_t k = 0; k < features.size(); ++k) map.features[features[k]] = feature_values[k];
    message = {};
  }
  return map;
}

/// The degrees of freedom: measured rows less free variables.
template <int Dim>
std::int64_t degrees_of_freedom(std::int64_t rows, const LogPart<Dim>& whole, std::size_t anchored) {
  const auto free_poses = static_cast<std::int64_t>(whole.poses.size() - anchored);
  return rows - kPoseDof<Dim> * free_poses - Dim * static_cast<std::int64_t>(whole.features.size());
}

/// Minimises the chi2 of the whole log over its regions, and gathers the map.
template <int Dim>
Expected<void> solve(const Communicator& comm, const Task& task, const LogPart<Dim>& whole, const Region<Dim>& region,
                     RunResult<Dim>& result) {
  const Stopwatch watch(result.seconds.polish);
  RegionProblem<Dim> problem(comm, region, task.mumps);
  if (auto room = check_room(comm, problem, task.most_megabytes); !room) return room;
  MinimiseOptions solver = task.run.solver;
  if (comm.any(result.local_maps > 0)) solver.relative_chi2 *= kRefiningShare;
  result.join = minimise(problem, solver);
  result.largest_rotation = comm.max(largest_rotation_update(region.partial.state, problem.system().estimate()));
  if (auto determined = comm.agree(check_determined(whole, region, problem, result.join)); !determined) return determined;
  if (result.join.status == MinimiseStatus::kSingular) {
    return bad_input(whole.source + ": the observations leave free to move what regions share");
  }
  result.chi2 = result.join.chi2;
  result.joint_bytes = problem.system().equations().factor_bytes();
  result.map = gathered(comm, whole, region, problem.system().estimate());
  result.dof = degrees_of_freedom(comm.sum(measured_rows(region)), whole, result.map.gauge.size());
  result.join_dof = result.dof;
  return {};
}

template <int Dim>
Expected<AnyFound> run_on(const Communicator& comm, const Task& task, MappedLog<Dim> log) {
  Found<Dim> found{{}, log.log};
  static_cast<RunFigures&>(found.result) = log.figures;
  Values<Dim> start = [&] {
    const Stopwatch watch(found.result.seconds.join);
    return start_of(comm, log.whole, log.share, std::move(log.maps), task.run);
  }();
  auto region = region_of(comm, log.whole, std::move(log.share), std::move(start));
  if (!region) return tl::unexpected(region.error());
  if (auto solved = solve(comm, task, log.whole, **region, found.result); !solved) return tl::unexpected(solved.error());
  found.result.schedule = task.run.schedule;
  return AnyFound(std::move(found));
}

/// By one schedule, not kAuto.
Expected<AnyFound> run_by(Schedule schedule, const Communicator& comm, const Reading& read, Task task) {
  task.run.schedule = schedule;
  return read().and_then(
      [&](AnyMappedLog log) { return std::visit([&](auto& any) { return run_on(comm, task, std::move(any)); }, log); });
}

RunFigures& figures_of(AnyFound& found) {
  return std::visit([](auto& any) -> RunFigures& { return any.result; }, found);
}

/// The first way whose map is settled, or else that of least chi2, where another one has confirmed it or all were tried.
Expected<AnyFound> run_by_best(const Communicator& comm, const Reading& read, const Task& task) {
  std::optional<AnyFound> best;
  for (const Schedule way : kWays) {
    auto found = run_by(way, comm, read, task);
    if (!found && best) continue;  // what is singular far from the optimum need not be so elsewhere
    if (!found) return found;
    RunFigures& figures = figures_of(*found);
    figures.is_settled = is_settled(way, figures.join, figures.largest_rotation);
    const bool is_confirmed = best && is_same_chi2(figures_of(*best).chi2, figures.chi2);
    if (!best || is_less_chi2(figures.chi2, figures_of(*best).chi2)) best = *std::move(found);
    if (is_confirmed || figures_of(*best).is_settled) break;
  }
  return *std::move(best);
}

}  // namespace

Expected<AnyFound> run(const Communicator& comm, const Reading& read, const Task& task) {
  demand_valid(task.run);
  if (task.run.schedule == Schedule::kAuto) return run_by_best(comm, read, task);
  return run_by(task.run.schedule, comm, read, task);
}

}  // namespace mapjoin::distributed
