// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin join`: from local maps to a global map.

#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <mapjoin/check/ties.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

namespace mapjoin::apps {
namespace {

template <int Dim>
void join_any(CommandRun& command_run, SubmapSet<Dim> set) {
  command_run.check_names(set.poses, set.features);
  const std::optional<SubmapSet<Dim>> kept = command_run.asks_features() ? std::optional(set) : std::nullopt;
  auto result = run(std::move(set), command_run.run_options(), command_run.stop()).value();
  if (kept) command_run.check_shared_features(*kept, result);
  command_run.write_map(result, static_cast<const Log<Dim>*>(nullptr));
}

/// Refuses the logs of several stores that nothing ties, with what ties stores; what is unsound in a log is told by the join.
template <int Dim>
void demand_tied(const std::string& input, const Log<Dim>& log) {
  const std::string advice = log.features.empty() ? "" : "; --features own --associate ties stores by features that they share";
  if (check_invariants(log)) demand(check_tied({input, log.poses, log.features}, ties_of(log), advice));
}

/// Joins the maps of a store; errors in its log are told of the store.
template <int Dim>
void join_any(CommandRun& command_run, StoredMaps<Dim> stored) {
  const auto& log = stored.log;
  demand_tied(command_run.run_report.input, log);
  command_run.check_names(log.poses, log.features);
  const Split parts = split_along(log, stored.segments);
  const auto of_store = [&](const Error& error) {
    return Error{error.kind, command_run.run_report.input + ": " + error.message};
  };
  auto result = run_from_maps(log, parts, std::move(stored.maps), command_run.run_options(), command_run.stop())
                    .map_error(of_store)
                    .value();
  command_run.check_shared_features(log, result);
  command_run.write_map(result, &log);
}

ExitCode join_maps(const Options& options, const std::stop_token& stop) {
  CommandRun command_run("join", options, stop);
  command_run.prepare(outputs_of_map(options));
  std::visit([&](auto&& any) { join_any(command_run, std::move(any)); }, command_run.read_maps());
  return command_run.conclude();
}

}  // namespace

void declare_join(Subcommand& command) {
  command.examples(
      "  mapjoin build data/manhattan2d.g2o -o manhattan2d.maps\n"
      "  mapjoin join manhattan2d.maps -o map.g2o");
  const auto options = std::make_shared<Options>();
  command.argument("MAPS", options->input, "A store, or a folder or archive of localmap_1, localmap_2, ... as .mat or .txt");
  command.path("-o,--output", options->output, "MAP", kMapFile);
  add_further(command, *options, "stores or sets of maps");
  add_schedule(command, *options);
  add_solver(command, *options);
  add_engine(command, *options);
  add_polish(command, *options);
  add_weights(command, *options);
  add_inflation(command, *options);
  add_reading_of_truth(command, *options);
  add_verdict(command, *options);
  add_association(command, *options);
  add_robust(command, *options, "rejected.csv beside the map names them");
  add_confidence(command, *options, "--associate and --robust");
  add_certainty(command, *options);
  add_reporting(command, *options);
  command.check([options] { return check_extension(options->output); });
  command.check([options] { return output_conflicts(inputs_of(*options, "MAPS"), outputs_of_map(*options)); });
  command.act([options](const std::stop_token& stop) { return join_maps(*options, stop); });
}

}  // namespace mapjoin::apps
