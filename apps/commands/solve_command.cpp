// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin solve`: full SLAM, the join of one-step maps.

#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <memory>
#include <variant>

namespace mapjoin::apps {
namespace {

ExitCode solve_input(const Options& options, const std::stop_token& stop) {
  CommandRun command_run("solve", options, stop);
  command_run.prepare(outputs_of_map(options));
  const auto solve_log = [&](const auto& log) {
    command_run.check_names(log.poses, log.features);
    auto result = solve(log, command_run.run_options(), stop).value();
    command_run.check_shared_features(log, result);
    command_run.write_map(result, &log);
    return command_run.conclude();
  };
  return std::visit(solve_log, command_run.read_log());
}

}  // namespace

void declare_solve(Subcommand& command) {
  command.examples(
      "  mapjoin solve data/manhattan2d.g2o -o map.g2o\n"
      "  mapjoin solve map.g2o -o again.csv --start file --method lm");
  const auto options = std::make_shared<Options>();
  command.argument("LOG", options->input, kLogFormats);
  command.path("-o,--output", options->output, "MAP", kMapFile);
  add_further_logs(command, *options);
  add_one_part(command, *options);
  add_gps(command, *options);
  add_schedule(command, *options);
  add_solver(command, *options);
  add_engine(command, *options);
  add_robust(command, *options, "rejected.csv beside the map names them");
  add_confidence(command, *options, "--robust");
  add_reading(command, *options);
  add_inflation(command, *options);
  add_verdict(command, *options);
  add_certainty(command, *options);
  add_reporting(command, *options);
  command.check([options] { return check_extension(options->output); });
  command.check([options] { return output_conflicts(inputs_of(*options, "LOG"), outputs_of_map(*options)); });
  command.act([options](const std::stop_token& stop) { return solve_input(*options, stop); });
}

}  // namespace mapjoin::apps
