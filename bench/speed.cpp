// SPDX-License-Identifier: BSD-3-Clause
// mapjoin_speed: whole programs on the same file from the same start, dead reckoning: mapjoin, the bare Gauss-Newton, Ceres,
// and the limit, the work that no solver can do without. They run in turns, on one thread; figures are medians, and ratios of
// runs side by side.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/model/error.hpp>
#include <string>
#include <vector>

#include "speed_result.hpp"

namespace mapjoin::bench {
namespace {

struct Arguments {
  std::vector<std::filesystem::path> files;
  std::vector<std::int64_t> worlds;  ///< Numbers of poses.
  int dimension = 2;
  int repeat = 5;
  std::vector<std::string> without;
  std::size_t limit = 150;
  std::filesystem::path folder = "build/speed";
  std::filesystem::path json;  ///< File for all figures; empty: none.
};

/// Simulates a world, anew at every call, so that the hash is that of the world.
Expected<Data> simulated(std::int64_t poses, const Arguments& arguments, const Surroundings& surroundings) {
  const std::string name = fmt::format("manhattan {}D {}", arguments.dimension, poses);
  const std::filesystem::path file = arguments.folder / fmt::format("manhattan{}d-{}.g2o", arguments.dimension, poses);
  const auto said = said_by({surroundings.programs / "mapjoin", "simulate", "--poses", std::to_string(poses), "--dim",
                             std::to_string(arguments.dimension), "--seed", "1", "-o", file});
  if (!said) return bad_input("cannot simulate " + name);
  return Data{name, file, file, false};
}

/// Local maps in a store, which is built unless they are one.
Expected<Data> stored(const std::filesystem::path& maps, const Arguments& arguments, const Surroundings& surroundings) {
  if (is_store(maps)) return Data{maps.filename(), maps, maps, true};
  const std::string name = std::filesystem::absolute(maps).parent_path().filename();
  const std::filesystem::path store = arguments.folder / (name + ".maps");
  const auto said = said_by({surroundings.programs / "mapjoin", "build", maps, "-o", store});
  if (!said) return bad_input("cannot store " + maps.string());
  return Data{name, maps, store, true};
}

Data log_in(const std::filesystem::path& file) {
  const std::string name = file.filename();
  return {name.substr(0, name.find('.')), file, file, false};
}

Expected<std::vector<Data>> data_of(const Arguments& arguments, const Surroundings& surroundings) {
  std::vector<Data> all;
  for (const std::int64_t poses : arguments.worlds) {
    auto world = simulated(poses, arguments, surroundings);
    if (!world) return tl::unexpected(world.error());
    all.push_back(*std::move(world));
  }
  for (const auto& file : arguments.files) {
    auto data = may_hold_maps(file) ? stored(file, arguments, surroundings) : log_in(file);
    if (!data) return tl::unexpected(data.error());
    all.push_back(*std::move(data));
  }
  return all;
}

std::string sha256_of(const Data& data) {
  return said_by({"sha256sum", data.source}).value_or("").substr(0, 64);
}

bool is_left_out(const Program& program, const Arguments& arguments) {
  return std::any_of(arguments.without.begin(), arguments.without.end(),
                     [&](const std::string& word) { return program.name.find(word) != std::string::npos; });
}

/// Runs the programs in turns, so that other load of the machine is shared by all.
Result contest(const Data& data, const Arguments& arguments, Surroundings surroundings) {
  Result result{data, sha256_of(data), std::numeric_limits<double>::infinity(), {}};
  for (Program& program : programs_for(data)) {
    if (result.runs.empty() || !is_left_out(program, arguments)) result.runs.push_back({std::move(program), {}});
  }
  const bool has_limit = std::any_of(result.runs.begin(), result.runs.end(),
                                     [](const Runs& runs) { return runs.program.kind == ProgramKind::kLimit; });
  if (has_limit) make_map(data, surroundings);
  for (int round = 0; round < arguments.repeat; ++round) {
    for (Runs& runs : result.runs) {
      if (!runs.trials.empty() && !runs.trials.back().chi2) continue;
      surroundings.optimum = result.optimum;
      const Trial trial = try_program(runs.program, data, surroundings);
      fmt::print(stderr, "{} {}/{} {}: {:.3f} s {}\n", data.name, round + 1, arguments.repeat, runs.program.name,
                 trial.cpu_seconds, trial.failure);
      result.optimum = std::min(result.optimum, trial.chi2.value_or(result.optimum));
      runs.trials.push_back(trial);
    }
  }
  return result;
}

/// Keeps BLAS and OpenMP to one thread in every program; its own threads are those that it is asked for.
void keep_to_one_thread() {
  for (const char* name : {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"}) ::setenv(name, "1", 1);
}

Expected<void> compare(const Arguments& arguments) {
  keep_to_one_thread();
  std::error_code failure;
  std::filesystem::create_directories(arguments.folder, failure);  // what cannot be made cannot be written into either
  const Surroundings surroundings{std::filesystem::read_symlink("/proc/self/exe").parent_path(), arguments.folder, 0.0,
                                  arguments.limit};
  const auto all = data_of(arguments, surroundings);
  if (!all) return tl::unexpected(all.error());
  std::vector<Result> results;
  for (const Data& data : *all) {
    results.push_back(contest(data, arguments, surroundings));
    if (!arguments.json.empty()) {
      if (auto written = write_file(arguments.json, json_of(results).dump(2) + "\n"); !written) return written;
    }
  }
  for (const Result& result : results) fmt::print("{}: sha256 {}\n", result.data.name, result.sha256);
  fmt::print("\n{}", table_of(results));
  return {};
}

}  // namespace
}  // namespace mapjoin::bench

int main(int argc, char** argv) {
  mapjoin::bench::Arguments arguments;
  CLI::App app("Whole programs on the same file: mapjoin, the bare Gauss-Newton, Ceres, and the limit.", "mapjoin_speed");
  app.add_option("files", arguments.files, "Logs, and local maps to be joined");
  app.add_option("--world", arguments.worlds, "Simulated walks of so many poses")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::PositiveNumber);
  app.add_option("--dim", arguments.dimension, "Of the walks, 2 or 3")->capture_default_str()->check(CLI::Range(2, 3));
  app.add_option("--repeat", arguments.repeat, "Runs of each program")->capture_default_str()->check(CLI::PositiveNumber);
  app.add_option("--without", arguments.without,
                 "Programs left out, by words of their names; not the first, mapjoin on one thread")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option("--limit", arguments.limit, "CPU seconds after which other programs than run are stopped; 0: none")
      ->capture_default_str();
  app.add_option("--folder", arguments.folder, "For worlds and maps")->capture_default_str();
  app.add_option("--json", arguments.json, "Write all figures into this file");
  CLI11_PARSE(app, argc, argv);
  const auto done = mapjoin::bench::compare(arguments);
  if (!done) fmt::print(stderr, "mapjoin_speed: {}\n", done.error().message);
  return done ? 0 : 5;
}
