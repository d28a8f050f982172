// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin join`: from local maps to a global map.

#include <apps/commands/command_run.hpp>
#include <apps/commands/commands.hpp>
#include <apps/map_file.hpp>
#include <apps/output_conflicts.hpp>
#include <memory>
#include <utility>
#include <variant>

namespace mapjoin::apps {
namespace {

constexpr const char* kExamples =
    "  mapjoin build data/manhattan2d.g2o -o manhattan2d.maps\n"
    "  mapjoin join manhattan2d.maps -o map.g2o";

template <int Dim>
Expected<ExitCode> join_any(CommandRun& command_run, MapSet<Dim> set) {
  auto result = run(std::move(set), command_run.run_options(), command_run.stop());
  if (!result) return tl::unexpected(result.error());
  if (auto written = command_run.write_map(*result, static_cast<const Log<Dim>*>(nullptr)); !written) {
    return tl::unexpected(written.error());
  }
  return command_run.conclude();
}

template <int Dim>
Expected<ExitCode> join_any(CommandRun& command_run, StoredMaps<Dim> stored) {
  const Split parts = split_along(stored.log, stored.stretches);
  // What is wrong with the log in a store is said of the store.
  const auto of_store = [&](const Error& error) {
    return Error{error.kind, command_run.run_report.input + ": " + error.message};
  };
  auto result = run_from_maps(stored.log, parts, std::move(stored.maps), command_run.run_options(), command_run.stop())
                    .map_error(of_store);
  if (!result) return tl::unexpected(result.error());
  if (auto written = command_run.write_map(*result, &stored.log); !written) return tl::unexpected(written.error());
  return command_run.conclude();
}

Expected<ExitCode> join_maps(const Options& options, const std::stop_token& stop) {
  CommandRun command_run("join", options, stop);
  if (auto ready = command_run.check_outputs().and_then([&] { return command_run.read_truth(); }); !ready) {
    return tl::unexpected(ready.error());
  }
  auto maps = command_run.read_maps();
  if (!maps) return tl::unexpected(maps.error());
  return std::visit([&](auto& any) { return join_any(command_run, std::move(any)); }, *maps);
}

void declare(Subcommand& command) {
  const auto options = std::make_shared<Options>();
  command.argument("MAPS", options->input, "A store, or a folder or archive of localmap_1, localmap_2, ... as .mat or .txt");
  command.path("-o,--output", options->output, "MAP", kMapFile);
  add_schedule(command, *options);
  add_solver(command, *options);
  add_engine(command, *options);
  add_polish(command, *options);
  add_weights(command, *options);
  add_certainty(command, *options);
  add_reporting(command, *options);
  command.check([options] { return check_extension(options->output); });
  command.check([options] { return output_conflicts(files_of_map(*options, "MAPS")); });
  command.act([options](const std::stop_token& stop) { return join_maps(*options, stop); });
}

}  // namespace

std::unique_ptr<Subcommand> join_command(CLI::App& app) {
  return std::make_unique<Subcommand>(app, "join", "From local maps to a global map", kExamples, declare);
}

}  // namespace mapjoin::apps
