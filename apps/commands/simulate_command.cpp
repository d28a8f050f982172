// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin simulate`: logs with their truth.

#include <fmt/format.h>

#include <apps/commands/commands.hpp>
#include <apps/console.hpp>
#include <apps/map_file.hpp>
#include <apps/output_conflicts.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <memory>

namespace mapjoin::apps {
namespace {

constexpr const char* kExamples =
    "  mapjoin simulate --poses 1000 --seed 7 -o town.g2o --truth town.truth.tum\n"
    "  mapjoin simulate --dim 3 --poses 2000 --seed 1 -o building.g2o\n"
    "  mapjoin simulate --poses 500 --noise-multiplier 0 -o without-errors.g2o";

enum class World { kManhattan };
constexpr auto enum_names(World) {
  return std::to_array<EnumName<World>>({{World::kManhattan, "manhattan"}});
}

struct SimulateOptions {
  World world = World::kManhattan;
  int dimension = 2;
  ManhattanOptions manhattan;
  std::filesystem::path log;
  std::filesystem::path truth;  ///< Empty: none.
  bool quiet = false;
};

template <int Dim>
Expected<ExitCode> simulate_in(const SimulateOptions& options, const std::stop_token& stop) {
  const auto writable = check_writable(options.log).and_then([&] { return check_map_writable(options.truth); });
  if (!writable) return tl::unexpected(writable.error());
  const Simulation<Dim> simulation = simulate_manhattan<Dim>(options.manhattan, stop);
  const Log<Dim>& log = simulation.log;
  if (stop.stop_requested()) return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted"});
  if (auto written = write_g2o(log, options.log); !written) return tl::unexpected(written.error());
  Lines lines;
  lines.add("log", fmt::format("{}: {}D, {} poses, {} features, {} observations", options.log.string(), Dim, log.poses.size(),
                               log.features.size(), log.observations().size()));
  if (!options.truth.empty()) {
    const auto written = write_map_file(simulation.truth, static_cast<const Log<Dim>*>(nullptr), options.truth);
    if (!written) return tl::unexpected(written.error());
    for (const std::string& file : *written) lines.add("truth", file);
  }
  if (options.quiet) return ExitCode::kDone;
  return write_stdout(lines.text()).map([] { return ExitCode::kDone; });
}

void add_path(Subcommand& command, ManhattanOptions& world) {
  command.group("Path");
  command.number<double>("--step", world.step, 0.0, "METRES", fmt::format("From pose to pose [{}]", world.step));
  command.number<double>("--block", world.block, 0.0, "METRES",
                         fmt::format("From corner to corner, a multiple of the step [{}]", world.block));
  command.option("--side", "METRES", "Of the square that the walk stays in [2 sqrt(poses / 5)]",
                 [&world](const std::string& word) -> std::optional<std::string> {
                   world.side = number_in<double>(word);
                   return world.side ? std::nullopt : std::optional<std::string>("not a number");
                 });
  command.number<std::int64_t>("--storeys", world.storeys, 1, "N",
                               fmt::format("Levels one block apart, in space [{}]", world.storeys));
}

void add_sensor(Subcommand& command, ManhattanOptions& world) {
  command.group("Features and sensor");
  command.number<double>("--feature-cell", world.feature_cell, 0.0, "METRES",
                         fmt::format("One feature in every square (cube) of this side [{}]", world.feature_cell));
  command.number<double>("--feature-jitter", world.feature_jitter, 0.0, "METRES",
                         fmt::format("Off its centre by at most so much along every axis [{}]", world.feature_jitter));
  command.number<double>("--range", world.range, 0.0, "METRES", fmt::format("Of the sensor [{}]", world.range));
  command.number<double>("--chance", world.chance, 0.0, "P",
                         fmt::format("Of a feature in range to be seen [{}]", world.chance));
}

void add_noise(Subcommand& command, ManhattanOptions& world) {
  command.group("Noise (standard deviations)");
  command.number<double>("--step-noise", world.step_noise, 0.0, "METRES",
                         fmt::format("Of a step, along every axis [{}]", world.step_noise));
  command.number<double>("--turn-noise", world.turn_noise, 0.0, "RADIANS",
                         fmt::format("Of a step, about every axis [{:.6f}]", world.turn_noise));
  command.number<double>("--observation-noise", world.observation_noise, 0.0, "METRES",
                         fmt::format("Of an observation, along every axis [{}]", world.observation_noise));
  command.number<double>("--noise-multiplier", world.noise_multiplier, 0.0, "X",
                         fmt::format("Errors made, by those stated; 0: none are made [{}]", world.noise_multiplier));
}

void declare(Subcommand& command) {
  const auto options = std::make_shared<SimulateOptions>();
  ManhattanOptions& world = options->manhattan;
  command.choice("--world", options->world, "Streets; in space corridors and shafts");
  command.number<std::int64_t>("--poses", world.poses, 1, "N", fmt::format("From a hundred to millions [{}]", world.poses));
  command.choice("--dim", options->dimension, std::to_array<EnumName<int>>({{2, "2"}, {3, "3"}}), "Dimension");
  command.number<std::uint64_t>("--seed", world.seed, 0, "S", fmt::format("The same seed gives the same log [{}]", world.seed));
  command.output("-o,--output", options->log, "LOG", "Write the log, as g2o");
  command.path("--truth", options->truth, "FILE", "Write the true map: .tum (poses only), .csv (features beside it), else g2o");
  command.flag("--quiet", options->quiet, "No summary");
  add_path(command, world);
  add_sensor(command, world);
  add_noise(command, world);
  command.check([options] { return options->manhattan.validate(); });
  command.check([options] { return output_conflicts({{"--output", options->log}, {"--truth", options->truth}}); });
  command.act([options](const std::stop_token& stop) {
    return options->dimension == 2 ? simulate_in<2>(*options, stop) : simulate_in<3>(*options, stop);
  });
}

}  // namespace

std::unique_ptr<Subcommand> simulate_command(CLI::App& app) {
  return std::make_unique<Subcommand>(app, "simulate", "A log with its truth", kExamples, declare);
}

}  // namespace mapjoin::apps
