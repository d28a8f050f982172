// SPDX-License-Identifier: BSD-3-Clause
// mapjoin_noise: how often each method reaches the optimum of simulated worlds, as odometry gets worse.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <string>
#include <tests/support/ceres_reference.hpp>
#include <vector>

namespace mapjoin {
namespace {

struct Arguments {
  std::filesystem::path folder = "build/noise";
  std::vector<double> levels = {1, 3, 6, 10, 15, 20, 30};
  std::size_t worlds = 50;
  std::int64_t poses = 1000;
};

/// A kind of world, rich or poor by how far its features are apart.
struct Surroundings {
  const char* name;
  double feature_cell;  // (m): a sensor of 3 m sees 28.3 m² at a time
};
constexpr std::array kSurroundings = {Surroundings{"rich", 2.17}, Surroundings{"poor", 7.5}};

/// chi2 of the whole log that a method ends at; infinite if it gives up.
using Solver = double (*)(const Simulation<2>&);

double finite(double chi2) {
  return std::isfinite(chi2) ? chi2 : std::numeric_limits<double>::infinity();
}

double chi2_of(const Expected<RunResult<2>>& result) {
  return finite(result ? result->chi2 : std::numeric_limits<double>::infinity());
}

double by_run(const Simulation<2>& world) {
  return chi2_of(run(world.log, without_verdict()));
}

double by_gradual(const Simulation<2>& world) {
  RunOptions options = without_verdict();
  options.schedule = Schedule::kBatch;
  options.state = JoinedState::kRelative;
  options.gradual = true;
  return chi2_of(run(world.log, options));
}

double by_full_slam(const Log<2>& log, Method method, Start start) {
  RunOptions options = without_verdict();
  options.schedule = Schedule::kBatch;
  options.solver.method = method;
  options.start = start;
  return chi2_of(solve(log, options));
}

double by_gauss_newton(const Simulation<2>& world) {
  return by_full_slam(world.log, Method::kGaussNewton, Start::kComposed);
}

template <testing::ReferenceMethod method>
double by_ceres(const Simulation<2>& world) {
  testing::ReferenceOptions options;
  options.method = method;
  options.max_iterations = 200;
  options.function_tolerance = 1e-10;
  return finite(testing::ceres_optimum(world.log, testing::odometry_start(world.log), options).chi2);
}

double by_truth(const Simulation<2>& world) {
  Log<2> log = world.log;
  log.initial.poses = world.truth.poses;
  log.initial.features = world.truth.features;
  return by_full_slam(log, Method::kDogleg, Start::kFile);
}

struct Contender {
  const char* name;
  Solver solve;
};
constexpr std::array kContenders = {
    Contender{"mapjoin run", by_run},
    Contender{"mapjoin run --batch gradual", by_gradual},
    Contender{"Gauss-Newton, full SLAM", by_gauss_newton},
    Contender{"Ceres Levenberg-Marquardt", by_ceres<testing::ReferenceMethod::kLevenbergMarquardt>},
    Contender{"Ceres dogleg", by_ceres<testing::ReferenceMethod::kDogleg>},
    Contender{"from the truth", by_truth}};
using Chi2s = std::array<double, kContenders.size()>;

Simulation<2> world_of(const Surroundings& surroundings, double level, std::size_t world, std::int64_t poses) {
  ManhattanOptions options;
  options.poses = poses;
  options.seed = world + 1;
  options.feature_cell = surroundings.feature_cell;
  options.step_noise *= level;
  options.turn_noise *= level;
  return simulate_manhattan<2>(options);
}

/// The chi2 of each contender in each world.
std::vector<Chi2s> contest(const Surroundings& surroundings, double level, const Arguments& arguments) {
  std::vector<Chi2s> reached(arguments.worlds);
  parallel_for(arguments.worlds, [&](std::size_t w) {
    const Simulation<2> world = world_of(surroundings, level, w, arguments.poses);
    for (std::size_t c = 0; c < kContenders.size(); ++c) reached[w][c] = kContenders[c].solve(world);
  });
  return reached;
}

bool is_best(const Chi2s& chi2, std::size_t contender) {
  return std::isfinite(chi2[contender]) && chi2[contender] <= *std::min_element(chi2.begin(), chi2.end()) * (1.0 + 1e-6);
}

/// Prints the rates in one kind of surroundings, a row per level, and adds all chi2 to the CSV.
void contest_in(const Surroundings& surroundings, const Arguments& arguments, std::string& csv) {
  for (const double level : arguments.levels) {
    const auto reached = contest(surroundings, level, arguments);
    fmt::print("| {} | \u00d7{} |", surroundings.name, level);
    for (std::size_t c = 0; c < kContenders.size(); ++c) {
      const auto hits = std::count_if(reached.begin(), reached.end(), [&](const Chi2s& chi2) { return is_best(chi2, c); });
      fmt::print(" {} |", hits);
      for (std::size_t w = 0; w < reached.size(); ++w) {
        csv += fmt::format("{},{},{},\"{}\",{:.9g}\n", surroundings.name, level, w + 1, kContenders[c].name, reached[w][c]);
      }
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}

Expected<void> noise(const Arguments& arguments) {
  std::error_code failure;
  std::filesystem::create_directories(arguments.folder, failure);  // what cannot be made cannot be written into either
  fmt::print(
      "Worlds of {} poses, {} of each kind; how many of them each method brings to the best chi2 of all.\n\n| features | noise "
      "|",
      arguments.poses, arguments.worlds);
  for (const Contender& contender : kContenders) fmt::print(" {} |", contender.name);
  std::string rule = "\n|---|---|";
  for (std::size_t c = 0; c < kContenders.size(); ++c) rule += "---|";
  fmt::print("{}\n", rule);
  std::string csv = "features,noise,world,method,chi2\n";
  for (const Surroundings& surroundings : kSurroundings) contest_in(surroundings, arguments, csv);
  return write_file(arguments.folder / "noise.csv", csv);
}

}  // namespace
}  // namespace mapjoin

int main(int argc, char** argv) {
  mapjoin::Arguments arguments;
  CLI::App app("How often each method reaches the optimum of simulated worlds, as odometry gets worse.", "mapjoin_noise");
  app.add_option("-o,--output", arguments.folder, "Folder for noise.csv, chi2 of every world and method")
      ->capture_default_str();
  app.add_option("--levels", arguments.levels, "Of the odometry noise, in 0.03 m and 0.4 degrees a step")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  app.add_option("--worlds", arguments.worlds, "Per level, and as many rich as poor in features")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--poses", arguments.poses, "Of each world")->capture_default_str()->check(CLI::Range(2, 1'000'000));
  CLI11_PARSE(app, argc, argv);
  const auto done = mapjoin::noise(arguments);
  if (!done) fmt::print(stderr, "mapjoin_noise: {}\n", done.error().message);
  return done ? 0 : 5;
}
