// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/distributed/regions/region_problem.hpp>
#include <mapjoin/distributed/regions/regions_in_turn.hpp>
#include <mapjoin/distributed/run.hpp>
#include <mapjoin/distributed/start.hpp>
#include <mapjoin/join/assess.hpp>
#include <mapjoin/join/settled.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/solve/memory_limit.hpp>
#include <mapjoin/solve/minimise.hpp>
#include <optional>
#include <tuple>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// Makes room for the factor; kTooLarge if it takes more than `most_megabytes`.
template <typename Problem>
Expected<void> make_room(const Communicator& comm, Problem& problem, double most_megabytes) {
  const double fronts = comm.max(static_cast<double>(problem.factor_bytes()) / 1e6);
  const double separators = problem.solver().interface_megabytes();
  if (most_megabytes <= 0.0 || fronts + separators <= most_megabytes) return problem.solver().make_room();
  const auto megabytes = [](double size) { return in_megabytes(std::llround(1e6 * size)); };
  return tl::unexpected(Error{
      ErrorKind::kTooLarge,
      fmt::format("a rank's factor would take {} and its part of what regions share {}, more than the {} of --max-memory; "
                  "take more ranks or --regions, or --out-of-core",
                  megabytes(fronts), megabytes(separators), megabytes(most_megabytes))});
}

/// kBadInput, by name, if poses or features of this rank cannot be determined.
template <int Dim, typename Problem>
Expected<void> check_determined(const LogPart<Dim>& whole, Problem& problem) {
  const std::string free = problem.free_here(whole);
  if (free.empty()) return {};
  return bad_input_of(whole.source, free);
}

/// The map on the first rank; empty on the others. Poses and features of several regions have the same value in each.
template <int Dim, typename Problem>
GlobalMap<Dim> gathered(const Communicator& comm, const LogPart<Dim>& whole, const std::vector<Region<Dim>>& regions,
                        const Problem& problem) {
  std::vector<PoseIndex> anchored;
  Writer writer;
  for (std::size_t k = 0; k < regions.size(); ++k) {
    for (const PoseIndex place : regions[k].anchored) anchored.push_back(regions[k].poses[place]);
    const Values<Dim>& estimate = problem.estimate(k);
    writer.put(regions[k].poses).put(estimate.poses).put(regions[k].features).put(estimate.features);
  }
  anchored = comm.gather(anchored);
  std::vector<std::string> from = comm.collect(std::move(writer).bytes());
  GlobalMap<Dim> map;
  make_distinct(anchored);
  map.gauge = std::move(anchored);
  if (!comm.is_root()) return map;
  map.pose_ids = whole.poses;
  map.feature_ids = whole.features;
  map.conventions = whole.conventions;
  map.poses.resize(whole.poses.size());
  map.features.resize(whole.features.size(), Point<Dim>::Zero());
  for (std::string& message : from) {
    for (Reader reader(message); !reader.is_at_end();) {
      const auto poses = reader.template take<PoseIndex>();
      const auto pose_values = reader.template take<Pose<Dim>>();
      for (std::size_t k = 0; k < poses.size(); ++k) map.poses[poses[k]] = pose_values[k];
      const auto features = reader.template take<FeatureIndex>();
      const auto feature_values = reader.template take<Point<Dim>>();
      for (std::size_t k = 0; k < features.size(); ++k) map.features[features[k]] = feature_values[k];
    }
    release(message);
  }
  take_off_turns(map);
  return map;
}

/// The degrees of freedom: measured rows less free variables.
template <int Dim>
std::int64_t degrees_of_freedom(std::int64_t rows, const LogPart<Dim>& whole, std::size_t anchored) {
  const auto free_poses = static_cast<std::int64_t>(whole.poses.size() - anchored);
  return rows - kPoseDof<Dim> * free_poses - Dim * static_cast<std::int64_t>(whole.features.size());
}

/// Minimises the chi2 of the whole log over its regions, and gathers the map.
template <typename Problem, int Dim>
Expected<void> solve_as(const Communicator& comm, const Task& task, const LogPart<Dim>& whole, Regions<Dim>& regions,
                        Found<Dim>& found) {
  RunResult<Dim>& result = found.result;
  const Stopwatch watch(result.seconds.polish);
  Problem problem(comm, regions, task.mumps);
  if (auto room = make_room(comm, problem, task.most_megabytes); !room) return room;
  MinimiseOptions solver = task.run.solver;
  if (comm.any(result.local_maps > 0)) solver.relative_chi2 *= kRefiningShare;
  result.join = {minimise(problem, solver)};
  std::int64_t rows = 0;
  for (std::size_t k = 0; k < regions.own.size(); ++k) {
    rows += regions.own[k].measured_rows;
    result.join.largest_rotation =
        std::max(result.join.largest_rotation, largest_rotation_update(regions.own[k].start, problem.estimate(k)));
  }
  result.join.largest_rotation = comm.max(result.join.largest_rotation);
  if (result.join.status == MinimiseStatus::kSingular) {
    if (auto determined = comm.agree(check_determined(whole, problem)); !determined) return determined;
    return bad_input_of(whole.source, "the observations leave free to move what regions share");
  }
  found.shared_by_regions = problem.interface().size;
  found.shared_by_ranks = problem.interface().outer.size;
  result.chi2 = result.join.chi2;
  result.joint_bytes = problem.factor_bytes();
  result.map = gathered(comm, whole, regions.own, problem);
  result.dof = degrees_of_freedom(comm.sum(rows), whole, result.map.gauge.size());
  result.join.dof = result.dof;
  return comm.agree(check_finite(result, whole.source));  // the map is on the first rank
}

template <int Dim>
Expected<void> solve(const Communicator& comm, const Task& task, const LogPart<Dim>& whole, Regions<Dim>& regions,
                     Found<Dim>& found) {
  // One region per rank is solved as one system, unless all poses of some rank are fixed: all ranks must call the solver, and a
  // system without unknowns does not.
  const bool is_one_each = regions.per_rank == 1 && !comm.any(variables_of(regions.own.front()).size() == 0);
  return is_one_each ? solve_as<RegionProblem<Dim>>(comm, task, whole, regions, found)
                     : solve_as<RegionsInTurn<Dim>>(comm, task, whole, regions, found);
}

template <int Dim>
Expected<AnyFound> run_on(const Communicator& comm, const Task& task, MappedLog<Dim> log) {
  if (auto worth = check_worth_it(comm, log.whole.source, log.whole.poses, task.regions); !worth)
    return tl::unexpected(worth.error());
  Found<Dim> found{{}, log.log};
  static_cast<RunFigures&>(found.result) = log.figures;
  Values<Dim> start = [&] {
    const Stopwatch watch(found.result.seconds.join);
    return start_of(comm, log.whole, log.share, std::move(log.maps), task.run);
  }();
  Regions<Dim> regions = regions_of(comm, log.whole, std::move(log.share), std::move(start), task.regions);
  if (auto solved = solve(comm, task, log.whole, regions, found); !solved) return tl::unexpected(solved.error());
  found.result.join.schedule = task.run.schedule;
  return AnyFound(std::move(found));
}

/// Runs by one schedule, not kAuto.
Expected<AnyFound> run_by(Schedule schedule, const Communicator& comm, AnyMappedLog log, Task task) {
  task.run.schedule = schedule;
  return std::visit([&](auto& any) { return run_on(comm, task, std::move(any)); }, log);
}

JoinResult& result_of(AnyFound& found) {
  return std::visit([](auto& any) -> JoinResult& { return any.result.join; }, found);
}

/// References to the figures of building local maps.
auto built_of(LogFigures& log, RunFigures& figures) {
  return std::tie(log, figures.build_iterations, figures.seconds.build);
}

/// The result of the best of the ways that kAuto tries. The first of them uses `log`; the others read it again.
Expected<AnyFound> run_by_best(const Communicator& comm, const Reading& read, AnyMappedLog log, const Task& task) {
  // A second reading may find the maps in stores: the figures of building them are those of the first.
  using Built = std::tuple<LogFigures, std::int64_t, double>;
  const Built built = std::visit([](auto& any) { return Built(built_of(any.log, any.figures)); }, log);
  std::optional<AnyMappedLog> first(std::move(log));
  const auto run_by_way = [&](Schedule way) {
    auto mapped = first ? Expected<AnyMappedLog>(*std::exchange(first, {})) : read();
    if (!mapped) return Expected<AnyFound>(tl::unexpected(mapped.error()));
    std::visit([&](auto& any) { built_of(any.log, any.figures) = built; }, *mapped);
    return run_by(way, comm, *std::move(mapped), task);
  };
  return best_of_ways<AnyFound>(run_by_way, result_of);
}

}  // namespace

Expected<AnyFound> run(const Communicator& comm, const Reading& read, const Task& task) {
  demand_valid(task.run);
  return read().and_then([&](AnyMappedLog log) {
    return task.run.schedule == Schedule::kAuto ? run_by_best(comm, read, std::move(log), task)
                                                : run_by(task.run.schedule, comm, std::move(log), task);
  });
}

}  // namespace mapjoin::distributed
