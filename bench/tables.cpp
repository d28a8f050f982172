// SPDX-License-Identifier: BSD-3-Clause
// mapjoin_tables: the results of each schedule, the effect of the length of local maps, and the course of Gauss-Newton in
// either state, as Markdown tables.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/run.hpp>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin {
namespace {

struct Arguments {
  std::vector<std::filesystem::path> files;
  std::vector<double> poses_per_map = {1, 5, 10, 16, 20, 35, 60, 100};
  bool identity = false;
  int iterations = 20;
};

using AnyData = std::variant<Log<2>, Log<3>, SubmapSet<2>, SubmapSet<3>>;

Expected<AnyData> read(const std::filesystem::path& path, bool identity) {
  ReadOptions options;
  options.repair_information = true;
  if (auto log = open_log(path, options)) {
    return std::visit(
        [&](auto& any) -> AnyData {
          if (identity) use_identity_covariance(any);
          return std::move(any);
        },
        *log);
  }
  auto set = read_local_map_set(path, options);
  if (!set) return tl::unexpected(set.error());
  return std::visit(
      [&](auto& any) -> AnyData {
        if (identity) use_identity_covariance(any);
        return std::move(any);
      },
      *set);
}

/// The name of the file, behind that of its folder if the path has one.
std::string name_of(const std::filesystem::path& path) {
  return (path.parent_path().filename() / path.filename()).string();
}

/// Does the work on what is in each file, and says what went wrong; returns the exit code, 3 if anything did.
template <typename Work>
int on_each(const Arguments& arguments, Work&& work) {
  int exit_code = 0;
  for (const auto& path : arguments.files) {
    const auto done = read(path, arguments.identity).and_then([&](const AnyData& data) -> Expected<void> {
      return work(name_of(path), data);
    });
    if (done) continue;
    fmt::print(stderr, "mapjoin_tables: {}\n", done.error().message);
    exit_code = 3;
  }
  return exit_code;
}

std::string status_of(const MinimiseResult& result) {
  return fmt::format("{}{}", result.iterations,
                     result.status == MinimiseStatus::kConverged ? "" : " (" + to_string(result.status) + ")");
}

int schedules(const Arguments& arguments) {
  fmt::print(
      "| data | schedule | iterations of the last join | chi2 of the join | recovered | polished | dof |\n"
      "|---|---|---|---|---|---|---|\n");
  return on_each(arguments, [](const std::string& name, const AnyData& data) -> Expected<void> {
    for (const Schedule schedule : {Schedule::kAligned, Schedule::kTree, Schedule::kSequential, Schedule::kBatch}) {
      RunOptions options = without_verdict();
      options.schedule = schedule;
      const auto print = [&](const auto& result) {
        if (!result) return fmt::print("| {} | {} | {} |\n", name, to_string(schedule), result.error().message);
        fmt::print("| {} | {} | {} | {:.4f} | {} | {} | {} |\n", name, to_string(schedule), status_of(result->join),
                   result->join.chi2, result->recovered_chi2 ? fmt::format("{:.4f}", *result->recovered_chi2) : "",
                   result->polish ? fmt::format("{:.4f}", result->polish->chi2) : "", result->dof);
      };
      std::visit([&](const auto& any) { print(run(any, options)); }, data);
      std::fflush(stdout);
    }
    return {};
  });
}

/// The largest distance between the same poses of two maps, and between the same features (m).
template <int Dim>
std::pair<double, double> differences(const GlobalMap<Dim>& a, const GlobalMap<Dim>& b) {
  double poses = 0.0;
  double features = 0.0;
  for (const PoseIndex p : indices(a.poses)) {
    poses = std::max(poses, (a.poses[p].translation - b.poses[p].translation).norm());
  }
  for (const FeatureIndex f : indices(a.features)) features = std::max(features, (a.features[f] - b.features[f]).norm());
  return {poses, features};
}

/// How many times one chi2 is the other; empty if that is 0.
std::string ratio_of(double chi2, double least) {
  return least > 0.0 ? fmt::format("{:.8f}", chi2 / least) : "";
}

template <int Dim>
Expected<void> splits_of(const Log<Dim>& log, const Arguments& arguments, const std::string& name) {
  RunOptions options = without_verdict();
  options.split = {SplitRule::kPoses, arguments.poses_per_map.front()};
  const auto first = run(log, options);
  if (!first) return tl::unexpected(first.error());
  for (const double steps : arguments.poses_per_map) {
    options.split = {SplitRule::kPoses, steps};
    const auto result = run(log, options);
    if (!result) return tl::unexpected(result.error());
    const auto [poses, features] = differences(first->map, result->map);
    fmt::print("| {} | {} | {} | {:.6f} | {} | {:.7f} | {:.1e} | {:.1e} |\n", name, steps, result->local_maps,
               *result->recovered_chi2, ratio_of(*result->recovered_chi2, result->chi2), result->chi2, poses, features);
    std::fflush(stdout);
  }
  return {};
}
template <int Dim>
Expected<void> splits_of(const SubmapSet<Dim>& set, const Arguments&, const std::string&) {
  return bad_input_of(set.source, "local maps are cut already: this table is of logs");
}

int splits(const Arguments& arguments) {
  fmt::print(
      "| data | poses per map | maps | chi2 before polishing | ratio | after | largest difference of poses (m) | of features "
      "(m) |\n"
      "|---|---|---|---|---|---|---|---|\n");
  return on_each(arguments, [&](const std::string& name, const AnyData& data) {
    return std::visit([&](const auto& any) { return splits_of(any, arguments, name); }, data);
  });
}

template <int Dim>
Expected<MinimiseResult> all_at_once(const Log<Dim>& log, const RunOptions& options) {
  return solve(log, options).map([](const auto& result) { return result.join; });
}
template <int Dim>
Expected<MinimiseResult> all_at_once(const SubmapSet<Dim>& set, const RunOptions& options) {
  return run(set, options).map([](const auto& result) { return result.join; });
}

/// chi2 at the composed start, then after each iteration of Gauss-Newton.
std::string course_of(const Expected<MinimiseResult>& result) {
  if (!result) return result.error().message;
  std::string course = fmt::format("{:.6g}", result->start_chi2);
  for (const double chi2 : result->course) course += fmt::format(", {:.6g}", chi2);
  return course + (result->status == MinimiseStatus::kConverged ? "" : " (" + to_string(result->status) + ")");
}

int courses(const Arguments& arguments) {
  fmt::print("| data | state | iterations | chi2 of the start and after each iteration |\n|---|---|---|---|\n");
  return on_each(arguments, [&](const std::string& name, const AnyData& data) -> Expected<void> {
    for (const JoinedState state : {JoinedState::kAbsolute, JoinedState::kRelative}) {
      RunOptions options = without_verdict();
      options.schedule = Schedule::kBatch;
      options.state = state;
      options.solver.method = Method::kGaussNewton;
      options.solver.max_iterations = arguments.iterations;
      const auto result = std::visit([&](const auto& any) { return all_at_once(any, options); }, data);
      fmt::print("| {} | {} | {} | {} |\n", name, to_string(state), result ? result->iterations : 0, course_of(result));
      std::fflush(stdout);
    }
    return {};
  });
}

}  // namespace
}  // namespace mapjoin

int main(int argc, char** argv) {
  mapjoin::Arguments arguments;
  CLI::App app("Tables of results, in Markdown");
  app.require_subcommand(1);
  auto* schedules = app.add_subcommand("schedules", "What each schedule reaches on each log or set of local maps");
  auto* splits = app.add_subcommand("splits", "What the number of poses per local map changes");
  auto* courses = app.add_subcommand("courses", "chi2 after each Gauss-Newton step from the composed start, in either state");
  for (auto* command : {schedules, splits, courses}) {
    command->add_option("files", arguments.files, "Logs, or sets of local maps")->required();
    command->add_flag("--identity", arguments.identity, "Replace every information matrix by the identity");
  }
  splits->add_option("--poses-per-map", arguments.poses_per_map, "Numbers to compare")->delimiter(',');
  courses->add_option("--iterations", arguments.iterations, "At most so many")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (*courses) return mapjoin::courses(arguments);
  return *schedules ? mapjoin::schedules(arguments) : mapjoin::splits(arguments);
}
