// SPDX-License-Identifier: BSD-3-Clause
// mapjoin_incremental: local maps joined one by one, beside one join of all of them: CPU time per map, and the excess of chi2
// over that of joining the same maps at once.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <limits>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/localmap/build.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin {
namespace {

struct Arguments {
  std::vector<std::filesystem::path> files;
  double poses_per_map = 10;
  std::size_t check = 0;
  std::size_t most = std::numeric_limits<std::size_t>::max();
};

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// The join of all updates at once.
struct Batch {
  double chi2 = 0.0;
  double seconds = 0.0;
};

template <int Dim>
Expected<Batch> batch_of(const std::vector<const SubmapUpdate<Dim>*>& updates) {
  const SubmapSet<Dim> set = set_of(updates);
  const SubmapGraph<Dim> graph = submap_graph_of(set);
  const double start = cpu_seconds();
  const auto joined = join(graph, set.poses, set.features, JoinOptions<Dim>{});
  if (!joined) return tl::unexpected(joined.error());
  return Batch{joined->result.chi2, cpu_seconds() - start};
}

struct Course {
  std::vector<double> seconds;    ///< CPU time per update.
  std::size_t eliminated = 0;     ///< Variables eliminated over all updates.
  std::size_t batch_adopted = 0;  ///< Updates after which the estimate is that of a join of all.
  double worst_excess = -std::numeric_limits<double>::infinity();  ///< Largest relative excess of chi2 over the batch's.
  double least_room = std::numeric_limits<double>::infinity();     ///< Least room from chi2 to 1.01 times the batch's + 0.5.
  Batch last;
};

template <int Dim>
Expected<Course> course_of(const std::vector<SubmapUpdate<Dim>>& updates, const Arguments& arguments) {
  Course course;
  IncrementalJoin<Dim> joined;
  std::vector<const SubmapUpdate<Dim>*> so_far;
  for (const SubmapUpdate<Dim>& update : updates) {
    so_far.push_back(&update);
    SubmapUpdate<Dim> copy = update;
    const double start = cpu_seconds();
    const AddedUpdate added = joined.add(std::move(copy)).value();
    course.seconds.push_back(cpu_seconds() - start);
    course.eliminated += added.eliminated;
    course.batch_adopted += added.batch_adopted ? 1 : 0;
    const bool is_last = so_far.size() == updates.size();
    if (!is_last && (arguments.check == 0 || so_far.size() % arguments.check != 0)) continue;
    const auto batch = batch_of(so_far);
    if (!batch) return tl::unexpected(batch.error());
    course.last = *batch;
    if (batch->chi2 > 1.0) course.worst_excess = std::max(course.worst_excess, added.chi2 / batch->chi2 - 1.0);
    course.least_room = std::min(course.least_room, 1.01 * batch->chi2 + 0.5 - added.chi2);
  }
  return course;
}

template <int Dim>
Expected<std::vector<SubmapUpdate<Dim>>> updates_of(const Log<Dim>& log, const Arguments& arguments) {
  Split segments = split(log, {SplitRule::kPoses, arguments.poses_per_map});
  const auto maps = build_local_maps<Dim>(log, segments, {});
  if (!maps) return tl::unexpected(maps.error());
  return submap_updates_of(log, segments, maps->maps);
}

/// An excess in words; empty if no chi2 was large enough to compare with.
std::string excess_in_words(double excess) {
  return std::isfinite(excess) ? fmt::format("{:.1e}", excess) : "";
}

template <int Dim>
Expected<std::string> row(const std::string& name, std::vector<SubmapUpdate<Dim>> updates, const Arguments& arguments) {
  updates.resize(std::min(updates.size(), arguments.most));
  return course_of(updates, arguments).map([&](const Course& course) {
    std::vector<double> seconds = course.seconds;
    std::sort(seconds.begin(), seconds.end());
    const double median = seconds[seconds.size() / 2];
    const double mean = std::accumulate(seconds.begin(), seconds.end(), 0.0) / static_cast<double>(seconds.size());
    const auto eliminated = static_cast<double>(course.eliminated) / static_cast<double>(seconds.size());
    return fmt::format("| {} | {} | {:.2f} | {:.2f} | {:.0f} | {:.0f} | {} | {:.0f} | {:.0f} | {} | {:.2f} |\n", name,
                       seconds.size(), 1e3 * median, 1e3 * mean, 1e3 * seconds.back(), eliminated, course.batch_adopted,
                       1e3 * course.last.seconds, course.last.seconds / median, excess_in_words(course.worst_excess),
                       course.least_room);
  });
}

/// The row of a log, whose local maps are built first, or of local maps.
Expected<std::string> row(const std::filesystem::path& path, const Arguments& arguments) {
  const std::string name = path.filename().string();
  const auto of_maps = [&]<int Dim>(const SubmapSet<Dim>& set) { return row(name, submap_updates_of(set), arguments); };
  const auto of_log = [&]<int Dim>(const Log<Dim>& log) {
    return updates_of(log, arguments).and_then([&](const auto& updates) { return row(name, updates, arguments); });
  };
  if (!may_hold_maps(path)) {
    return open_log(path, {}).and_then([&](const AnyLog& log) { return std::visit(of_log, log); });
  }
  return open_maps(path, {}).and_then([&](const AnyMaps& maps) -> Expected<std::string> {
    if (const auto* set = std::get_if<SubmapSet<2>>(&maps)) return of_maps(*set);
    if (const auto* set = std::get_if<SubmapSet<3>>(&maps)) return of_maps(*set);
    return bad_input(name + ": a store of a log; give the log");
  });
}

int table(const Arguments& arguments) {
  fmt::print(
      "| data | maps | median (ms) | mean (ms) | most (ms) | variables eliminated per map | joined anew | one batch join (ms) "
      "| "
      "batch / median | worst chi2 over batch | least room to 1 % + 0.5 |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& path : arguments.files) {
    const auto line = row(path, arguments);
    if (!line) {
      fmt::print(stderr, "{}\n", line.error().message);
      return 1;
    }
    fmt::print("{}", *line);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace mapjoin

int main(int argc, char** argv) {
  mapjoin::Arguments arguments;
  CLI::App app("Joining local maps one by one: CPU time per map, beside one join of all");
  app.add_option("LOG", arguments.files, "Logs, or sets of local maps")->required();
  app.add_option("--poses-per-map", arguments.poses_per_map, "Steps of a local map [10]")->check(CLI::Range(1.0, 1e9));
  app.add_option("--check", arguments.check,
                 "Join the maps so far at once after every so many, and compare chi2 [at the end only]");
  app.add_option("--most", arguments.most, "Only so many first maps")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  return mapjoin::table(arguments);
}
