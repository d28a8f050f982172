// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin simulate`: logs with their truth.

#include <fmt/format.h>

#include <apps/commands/subcommand.hpp>
#include <apps/console.hpp>
#include <apps/outputs.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/g2o/numbering.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <memory>

namespace mapjoin::apps {
namespace {

enum class World { kManhattan };
constexpr auto enum_names(World) {
  return std::to_array<EnumName<World>>({{World::kManhattan, "manhattan"}});
}

struct SimulateOptions {
  World world = World::kManhattan;
  int dimension = 2;
  ManhattanOptions manhattan;
  std::filesystem::path log;
  std::filesystem::path truth;  ///< File of the true map; empty: none.
  bool quiet = false;
};

NamedFiles outputs_of(const SimulateOptions& options) {
  NamedFiles files = {{"--output", options.log}};
  for (const auto& file : map_files(options.truth)) files.emplace_back("--truth", file);
  return files;
}

/// A violation, in words: a log whose name is that of another format.
std::vector<std::string> check_is_g2o(const std::filesystem::path& log) {
  if (!goes_by_extension(log) || extension_of(log) == ".g2o") return {};
  return {
      fmt::format("--output: the log is written in g2o, and {} is no name of it: give it .g2o, and `mapjoin convert` "
                  "writes it in other formats",
                  log.string())};
}

/// True if there is a summary: with --quiet, and beside an output on standard output, there is none.
bool has_summary(const SimulateOptions& options) {
  return !options.quiet && !is_stdout(options.log) && !is_stdout(options.truth);
}

/// Names the true features as the file of the log does, which has one numbering for poses and features.
template <int Dim>
void name_as_in_file(const Log<Dim>& log, GlobalMap<Dim>& truth) {
  const G2oNumbering numbering = number_for_g2o(log.poses, log.features).value();
  for (FeatureId& id : truth.feature_ids) id = {numbering(id)};
}

template <int Dim>
ExitCode simulate_in(const SimulateOptions& options, const std::stop_token& stop) {
  check_writable(outputs_of(options));
  Simulation<Dim> simulation = simulate_manhattan<Dim>(options.manhattan, stop);
  const Log<Dim>& log = simulation.log;
  if (stop.stop_requested()) fail(ErrorKind::kInterrupted, "interrupted");
  demand(write_g2o(log, options.log));
  Lines lines;
  lines.add("log", fmt::format("{}: {}D, {}, {}, {}", options.log.string(), Dim, plural(log.poses.size(), "pose"),
                               plural(log.features.size(), "feature"), plural(log.observations().size(), "observation")));
  if (!options.truth.empty()) {
    name_as_in_file(log, simulation.truth);
    demand(write_map_file(simulation.truth, static_cast<const Log<Dim>*>(nullptr), options.truth));
    for (const auto& file : map_files(options.truth)) lines.add("truth", file.string());
  }
  if (has_summary(options)) demand(write_stdout(lines.text()));
  return ExitCode::kDone;
}

void add_path(Subcommand& command, ManhattanOptions& world) {
  command.group("Path");
  command.number<double>("--step", world.step, 0.0, "METRES", "From pose to pose");
  command.number<double>("--block", world.block, 0.0, "METRES", "From corner to corner, a multiple of the step");
  command.option("--side", "METRES", "Of the square that the walk stays in [2 sqrt(poses / 5)]",
                 [&world](const std::string& word) -> std::optional<std::string> {
                   world.side = number_in<double>(word);
                   return world.side ? std::nullopt : std::optional<std::string>("not a number");
                 });
  command.number<std::int64_t>("--storeys", world.storeys, 1, "N", "Levels one block apart, in space");
}

void add_sensor(Subcommand& command, ManhattanOptions& world) {
  command.group("Features and sensor");
  command.number<double>("--feature-cell", world.feature_cell, 0.0, "METRES",
                         "One feature in every square (cube) of this side");
  command.number<double>("--feature-jitter", world.feature_jitter, 0.0, "METRES",
                         "Off its centre by at most so much along every axis");
  command.number<double>("--range", world.range, 0.0, "METRES", "Of the sensor");
  command.number<double>("--chance", world.chance, 0.0, "P", "Of a feature in range to be seen");
}

void add_noise(Subcommand& command, ManhattanOptions& world) {
  command.group("Noise (standard deviations)");
  command.number<double>("--step-noise", world.step_noise, 0.0, "METRES", "Of a step, along every axis");
  command.number<double>("--turn-noise", world.turn_noise, 0.0, "RADIANS", "Of a step, about every axis");
  command.number<double>("--observation-noise", world.observation_noise, 0.0, "METRES", "Of an observation, along every axis");
  command.number<double>("--noise-multiplier", world.noise_multiplier, 0.0, "X",
                         "Errors made, by those stated; 0: none are made");
}

}  // namespace

void declare_simulate(Subcommand& command) {
  command.examples(
      "  mapjoin simulate --poses 1000 --seed 7 -o town.g2o --truth town.truth.tum\n"
      "  mapjoin simulate --dim 3 --poses 2000 --seed 1 -o building.g2o\n"
      "  mapjoin simulate --poses 500 --noise-multiplier 0 -o without-errors.g2o\n"
      "  mapjoin simulate --poses 100000 --part 2/4 -o second-quarter.g2o");
  const auto options = std::make_shared<SimulateOptions>();
  ManhattanOptions& world = options->manhattan;
  command.choice("--world", options->world, "Streets; in space corridors and shafts");
  command.number<std::int64_t>("--poses", world.poses, 1, "N", "From one to millions");
  command.choice("--dim", options->dimension, std::to_array<EnumName<int>>({{2, "2"}, {3, "3"}}), "Dimension");
  command.number<std::uint64_t>("--seed", world.seed, 0, "S", "The same seed gives the same log");
  command.path("-o,--output", options->log, "LOG", "Write the log, as g2o", true);
  command.path("--truth", options->truth, "FILE",
               "Write the true map: .tum (poses only), .csv (features beside it), .mat, else g2o");
  add_part(command, "Only the K-th of N parts, with the memory of one; the edges of all parts are those of the whole log",
           [&world](std::size_t part, std::size_t parts) {
             world.part = static_cast<std::int64_t>(part);
             world.parts = static_cast<std::int64_t>(parts);
           });
  command.flag("--quiet", options->quiet, "No summary");
  add_path(command, world);
  add_sensor(command, world);
  add_noise(command, world);
  command.check([options] { return options->manhattan.validate(); });
  command.only_with("--storeys", "--dim 3", [options] { return options->dimension == 3; });
  command.check([options] { return check_is_g2o(options->log); });
  command.check([options] { return output_conflicts({}, outputs_of(*options)); });
  command.act([options](const std::stop_token& stop) {
    return options->dimension == 2 ? simulate_in<2>(*options, stop) : simulate_in<3>(*options, stop);
  });
}

}  // namespace mapjoin::apps
