// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin build`: from a log to a store of local maps, going on with an interrupted build; or from the files of local maps to
// a store.

#include <fmt/format.h>

#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/io/store/store.hpp>
#include <mapjoin/localmap/stored_build.hpp>
#include <mapjoin/model/lists.hpp>
#include <memory>
#include <variant>

namespace mapjoin::apps {
namespace {

/// True if an option says that features of the same id are the same in several inputs.
bool says_shared(const Options& options) {
  return !options.features_undecided && !options.merging.own_features;
}

template <int Dim>
void build_all(CommandRun& command_run, const Log<Dim>& log, const Split& parts, StoreWriter<Dim>& store) {
  const Stopwatch watch(command_run.run_report.figures.seconds.build);
  const std::size_t before = store.done().size();
  RunFigures& figures = command_run.run_report.figures;
  const RunOptions& options = command_run.run_options();
  figures.build_iterations =
      build_into(store, log, parts, {options.solver, options.progress_of(Stage::kBuild)}, command_run.stop()).value();
  figures.local_maps = store.done().size() - store.undetermined();
  figures.raw_segments = parts.segments.size() - map_segments(parts.segments).size() + store.undetermined();
  figures.poses_per_map = parts.poses_per_map;
  command_run.run_report.has_local_maps = true;
  command_run.run_report.is_resumed = before > 0;
  demand(store.finish());
}

template <int Dim>
void store_any(CommandRun& command_run, const Log<Dim>& log) {
  demand(check_connected(log));
  SplitOptions cut = command_run.run_options().split;
  if (cut.rule == SplitRule::kAuto) cut.amount = 2.0;  // maps of one step would be the log itself
  const Split parts = split(log, cut);
  const Options& options = command_run.options();
  auto store = StoreWriter<Dim>::open(options.output, log, segments_of(options.share, parts),
                                      build_settings(command_run.run_options().solver), {}, options.share, says_shared(options))
                   .value();
  command_run.run_report.was_damaged = store.found_damaged();
  build_all(command_run, log, parts, store);
}
/// Stores local maps that others built as they are.
template <int Dim>
void store_any(CommandRun& command_run, SubmapSet<Dim> set) {
  set.features_are_shared |= says_shared(command_run.options());
  demand(timed(command_run.run_report.write_seconds, [&] { return write_store(set, command_run.options().output); }));
}
template <int Dim>
void store_any(CommandRun& command_run, const StoredMaps<Dim>&) {
  fail(ErrorKind::kUsage, command_run.run_report.input + ": is a store already");
}

ExitCode build_input(const Options& options, const std::stop_token& stop) {
  CommandRun command_run("build", options, stop);
  command_run.prepare(outputs_of_store(options));
  command_run.with_log_or_maps([&](auto&& input) { store_any(command_run, std::move(input)); });
  command_run.run_report.files.push_back(options.output.string());
  command_run.write_associations();
  return command_run.conclude();
}

}  // namespace

void declare_build(Subcommand& command) {
  command.examples(
      "  mapjoin build data/manhattan2d.g2o -o manhattan2d.maps\n"
      "  mapjoin join manhattan2d.maps -o map.g2o");
  const auto options = std::make_shared<Options>();
  command.argument("LOG|MAPS", options->input,
                   kLogFormats +
                       ". Or local maps of others, which are stored as they are: a folder or archive of localmap_1, "
                       "localmap_2, ... as .mat or .txt");
  command.path("-o,--output", options->output, "MAPS",
               "Write the store; until it is done it is MAPS.partial, from which the same command goes on", true);
  add_further_logs(command, *options);
  add_splitting(command, *options);
  add_share(command, *options);
  add_solver(command, *options);
  add_association(command, *options);
  add_confidence(command, *options, "--associate");
  add_reading(command, *options);
  add_inflation(command, *options);
  add_reporting(command, *options);
  command.check([options] { return output_conflicts(inputs_of(*options, "LOG|MAPS"), outputs_of_store(*options)); });
  command.check([options] {
    NamedFiles files = inputs_of(*options, "LOG|MAPS");
    append(files, outputs_of_store(*options));
    return unfinished_store_conflicts(files, "--output", options->output);
  });
  command.check([options, &command] { return check_uncut(command, *options); });
  command.act([options](const std::stop_token& stop) { return build_input(*options, stop); });
}

}  // namespace mapjoin::apps
