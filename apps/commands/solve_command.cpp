// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin solve`: full SLAM, the join of one-step maps.

#include <apps/commands/command_run.hpp>
#include <apps/commands/commands.hpp>
#include <apps/map_file.hpp>
#include <apps/output_conflicts.hpp>
#include <memory>
#include <variant>

namespace mapjoin::apps {
namespace {

constexpr const char* kExamples =
    "  mapjoin solve data/manhattan2d.g2o -o map.g2o\n"
    "  mapjoin solve map.g2o -o again.csv --start file --method lm";

template <int Dim>
Expected<ExitCode> solve_log(CommandRun& command_run, const Log<Dim>& log) {
  auto result = solve(log, command_run.run_options(), command_run.stop());
  if (!result) return tl::unexpected(result.error());
  if (auto written = command_run.write_map(*result, &log); !written) return tl::unexpected(written.error());
  return command_run.conclude();
}

Expected<ExitCode> solve_input(const Options& options, const std::stop_token& stop) {
  CommandRun command_run("solve", options, stop);
  if (auto ready = command_run.check_outputs().and_then([&] { return command_run.read_truth(); }); !ready) {
    return tl::unexpected(ready.error());
  }
  const auto log = command_run.read_log();
  if (!log) return tl::unexpected(log.error());
  return std::visit([&](const auto& any) { return solve_log(command_run, any); }, *log);
}

void declare(Subcommand& command) {
  const auto options = std::make_shared<Options>();
  command.argument("LOG", options->input, kLogFormats);
  command.path("-o,--output", options->output, "MAP", kMapFile);
  add_schedule(command, *options);
  add_solver(command, *options);
  add_engine(command, *options);
  add_reading(command, *options);
  add_certainty(command, *options);
  add_reporting(command, *options);
  command.check([options] { return check_extension(options->output); });
  command.check([options] { return output_conflicts(files_of_map(*options, "LOG")); });
  command.act([options](const std::stop_token& stop) { return solve_input(*options, stop); });
}

}  // namespace

std::unique_ptr<Subcommand> solve_command(CLI::App& app) {
  return std::make_unique<Subcommand>(app, "solve", "Full SLAM of a log, as the join of one-step maps", kExamples, declare);
}

}  // namespace mapjoin::apps
