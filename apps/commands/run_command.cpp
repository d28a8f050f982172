// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin run`: from a log to a global map.

#include <fmt/format.h>

#include <algorithm>
#include <apps/certainty.hpp>
#include <apps/commands/command_run.hpp>
#include <apps/commands/follow.hpp>
#include <apps/commands/subcommand.hpp>
#include <apps/outputs.hpp>
#include <apps/picture/links.hpp>
#include <apps/picture/plotted_map.hpp>
#include <apps/report/report.hpp>
#include <functional>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/g2o/numbering.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/parallel/pieces.hpp>
#include <memory>
#include <optional>
#include <set>
#include <variant>

namespace mapjoin::apps {
namespace {

/// The user's sessions if there are several; otherwise empty.
template <int Dim>
std::vector<std::uint32_t> sessions_in(const GlobalMap<Dim>& map) {
  std::set<std::uint32_t> sessions;
  for (const PoseId& id : map.pose_ids) sessions.insert(id.session);
  return sessions.size() > 1 ? std::vector(sessions.begin(), sessions.end()) : std::vector<std::uint32_t>();
}

/// The poses of one session.
template <int Dim>
GlobalMap<Dim> session_of(const GlobalMap<Dim>& map, std::uint32_t session) {
  GlobalMap<Dim> part;
  for (const PoseIndex p : indices(map.poses)) {
    if (map.pose_ids[p].session != session) continue;
    part.pose_ids.push_back(map.pose_ids[p]);
    part.poses.push_back(map.poses[p]);
    if (!map.stamps_ns.empty()) part.stamps_ns.push_back(map.stamps_ns[p]);
  }
  return part;
}

/// The names of the files of the folder; without those of covariances if the map has none.
std::vector<std::string> names_of(const Options& options, bool has_covariances, const std::vector<std::uint32_t>& sessions) {
  std::vector<std::string> names(kFilesOfRun.begin(), kFilesOfRun.end());
  for (const std::uint32_t session : sessions) names.push_back(trajectory_of(session));
  for (const ExtraFile& file : extra_files(options, has_covariances)) names.emplace_back(file.in_folder);
  names.emplace_back(kReportOfRun);
  return names;
}

/// The picture of a map, with the links that were rejected.
template <int Dim>
std::string picture_of(const RunResult<Dim>& result, const Log<Dim>& log, const RunReport& run_report) {
  PlottedMap<Dim> map = plotted(result, log);
  add_rejected_links(run_report, map.links);
  return picture(map_layers<Dim>({std::move(map)}, nullptr));
}

template <int Dim>
Expected<void> write_map_files(const CommandRun& command_run, const RunResult<Dim>& result, const Log<Dim>& log,
                               const OutputFolder& folder) {
  const GlobalMap<Dim>& map = result.map;
  std::vector<std::function<Expected<void>()>> files = {
      [&] { return write_g2o(map, &log, folder.aside(kMapOfRun)); },
      [&] { return write_tum(map, folder.aside(kTrajectoryOfRun)); },
      [&] { return write_csv(map, folder.aside(kPosesOfRun), folder.aside(kFeaturesOfRun)); },
      [&] { return write_file(folder.aside(kPictureOfRun), picture_of(result, log, command_run.run_report)); },
  };
  for (const std::uint32_t session : sessions_in(map)) {
    files.emplace_back([&, session] { return write_tum(session_of(map, session), folder.aside(trajectory_of(session))); });
  }
  for (const ExtraFile& file : extra_files(command_run.options(), result.marginals.has_value())) {
    files.emplace_back([&, file] { return command_run.write_extra(file.extra, result, &log, folder.aside(file.in_folder)); });
  }
  return parallel_try(files.size(), [&](std::size_t k) { return files[k](); });
}

/// Says which folders hold earlier runs beside the one that wrote into `written`. They may be somebody's: none is removed.
void say_other_runs(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& written) {
  for (const std::filesystem::path& run : other_runs_in(folder, written)) {
    say(run.string() + ": holds the map of an earlier run, not of this one; remove it where it is of no use");
  }
}

template <int Dim>
void write_folder(CommandRun& command_run, const RunResult<Dim>& result, const Log<Dim>& log, OutputFolder& folder) {
  const std::vector<std::string> names = names_of(command_run.options(), result.marginals.has_value(), sessions_in(result.map));
  command_run.progress().close();
  const std::string capped = ellipse_cap(result.map).in_words();
  if (!capped.empty()) say(std::string(kPictureOfRun) + ": " + capped);
  for (const std::string& name : names) command_run.run_report.files.push_back(folder.file(name).string());
  demand(timed(command_run.run_report.write_seconds, [&] { return write_map_files(command_run, result, log, folder); }));
  command_run.run_report.renamed = in_words(number_for_g2o(result.map.pose_ids, result.map.feature_ids).value());
  demand(write_file(folder.aside(kReportOfRun), report(command_run.run_report)));
  command_run.check_interrupted();
  const std::filesystem::path& output = command_run.options().output;
  folder.commit(names, files_of_former_run(output));
  say_other_runs(output, {output});
}

template <int Dim>
ExitCode run_on(CommandRun& command_run, const Log<Dim>& log, std::optional<OutputFolder>& folder) {
  command_run.check_names(log.poses, log.features);
  RunResult<Dim> result = run(log, command_run.run_options(), command_run.stop()).value();
  command_run.check_shared_features(log, result);
  if (folder) {
    command_run.take(result);
    write_folder(command_run, result, log, *folder);
  } else {
    command_run.write_map(result, &log);
  }
  return command_run.conclude();
}

/// Runs on a log that is followed until it is complete; a stop ends the following, not the run on what is there.
ExitCode run_followed(CommandRun& command_run, const FollowOptions& following, const std::stop_token& stop,
                      std::optional<OutputFolder>& folder) {
  FollowedLog followed = follow(command_run.options(), following, stop);
  const AnyLog log = command_run.take_input(command_run.stamped(std::move(followed.log)).value());
  const ExitCode done = std::visit([&](const auto& any) { return run_on(command_run, any, folder); }, log);
  if (!followed.fault) return done;
  const bool is_written = !command_run.options().output.empty();
  fail(followed.fault->kind, followed.fault->message + (is_written ? "; the map of what stands before it is written" : ""));
}

/// Runs on the part of the log of `whole` with this number, which summary, report and messages name; the error if it has no
/// map.
template <int Dim>
Expected<ExitCode> run_part(const Options& options, const CommandRun& whole, std::size_t number, Log<Dim> part) {
  try {
    const std::string name = fmt::format(", part {}", number);
    part.source += name;
    CommandRun command_run("run", options, whole.stop());
    command_run.run_report.input += name;
    auto folder = output_folder(options.output);
    command_run.take_truth_of(whole);
    const AnyLog log = command_run.take_input(AnyLog(std::move(part)));
    return std::visit([&](const auto& any) { return run_on(command_run, any, folder); }, log);
  } catch (const tl::bad_expected_access<Error>& failure) {
    if (failure.error().kind == ErrorKind::kInterrupted || failure.error().kind == ErrorKind::kCannotWrite) throw;
    return tl::unexpected(failure.error());
  }
}

/// Runs on each part with the same options, but a folder of its own; the largest is the first. A part without a map does not
/// keep the others from theirs.
ExitCode run_parts(const Options& options, const std::stop_token& stop) {
  CommandRun whole("run", options, stop);
  whole.prepare({});
  const AnyLog log = whole.open_input();
  ExitCode worst = ExitCode::kDone;
  std::vector<std::filesystem::path> written;
  const auto run_each = [&](const auto& any) {
    whole.demand_truth(any);
    auto parts = split_into_parts(any);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      Options of_part = options;
      of_part.output = options.output / folder_of_part(k);
      const Expected<ExitCode> done = run_part(of_part, whole, k + 1, std::move(parts[k]));
      if (!done) say(done.error().message);
      if (done) written.push_back(of_part.output);
      worst = std::max(worst, done ? *done : exit_code_of(done.error().kind));
    }
  };
  std::visit(run_each, log);
  say_other_runs(options.output, written);
  return worst;
}

ExitCode run_log(const Options& options, const FollowOptions& following, const std::stop_token& stop) {
  if (options.parts == Parts::kAll) return run_parts(options, stop);
  CommandRun command_run("run", options, following.wanted ? std::stop_token() : stop);
  const bool is_file = names_map_file(options.output);
  auto folder = output_folder(is_file ? std::filesystem::path() : options.output);
  command_run.prepare(is_file ? outputs_of_map(options) : report_of(options));
  if (following.wanted) return run_followed(command_run, following, stop, folder);
  return std::visit([&](const auto& log) { return run_on(command_run, log, folder); }, command_run.read_log());
}

std::vector<std::string> check_files(const Options& options, const FollowOptions& following) {
  const NamedFiles inputs = inputs_of(options, "LOG");
  const bool is_folder = !options.output.empty() && !names_map_file(options.output);
  NamedFiles outputs = is_folder ? outputs_of(options) : outputs_of_map(options);
  outputs.emplace_back("--steps", following.steps);
  std::vector<std::string> violations = output_conflicts(inputs, outputs);
  NamedFiles all = files_read(inputs);
  append(all, outputs);
  if (is_folder) append(violations, conflicts_with_run(all, options.output, options.parts == Parts::kAll));
  return violations;
}

std::vector<std::string> check_parts(const Options& options) {
  if (options.parts != Parts::kAll) return {};
  if (options.output.empty() || names_map_file(options.output))
    return {"--parts all writes a folder for each part: it goes with -o DIR"};
  if (!options.gps.empty()) return {"--parts all makes maps that nothing ties, and --gps would: it goes with one map"};
  if (!options.report.empty()) return {"--parts all has a report in the folder of each part, not --report"};
  if (options.association) return {"--parts all goes by the ids of features, which --associate ignores: take --parts largest"};
  return {};
}

}  // namespace

void declare_run(Subcommand& command) {
  command.examples(
      "  mapjoin run data/manhattan2d.g2o\n"
      "  mapjoin run data/manhattan2d.g2o -o result\n"
      "  mapjoin run data/manhattan2d.g2o -o map.g2o\n"
      "  mapjoin run data/manhattan2d.g2o -o certain --covariances --truth data/manhattan2d.truth.tum\n"
      "  mapjoin run data/manhattan3d.g2o --poses-per-map 20 --report -\n"
      "  mapjoin run data/manhattan2d.g2o --follow --idle 0.5 --steps steps.jsonl");
  const auto options = std::make_shared<Options>();
  const auto following = std::make_shared<FollowOptions>();
  command.argument("LOG", options->input, kLogFormats);
  command.path("-o,--output", options->output, "DIR|MAP",
               "Write map.g2o, trajectory.tum, poses.csv, features.csv, map.svg and report.json into this folder; or the map "
               "alone: .g2o, .tum (poses only), .csv (features beside it), .mat");
  add_further_logs(command, *options);
  add_parts(command, *options);
  add_gps(command, *options);
  add_splitting(command, *options);
  add_schedule(command, *options);
  add_solver(command, *options);
  add_engine(command, *options);
  add_polish(command, *options);
  add_association(command, *options);
  add_robust(command, *options, "rejected.csv in the folder, or beside the map, names them");
  add_confidence(command, *options, "--associate and --robust");
  add_reading(command, *options);
  add_inflation(command, *options);
  add_verdict(command, *options);
  add_certainty(command, *options);
  add_following(command, *following);
  add_reporting(command, *options);
  command.check([options] { return check_extension(options->output, true); });
  command.check([options, following] { return check_files(*options, *following); });
  command.check([options, following]() -> std::vector<std::string> {
    const bool is_plain =
        options->further.empty() && options->stamps.empty() && options->gps.empty() && options->parts == Parts::kRefuse;
    const bool is_g2o = options->read.from.value_or(LogFormat::kG2o) == LogFormat::kG2o;
    if (!following->wanted || (is_plain && is_g2o)) return {};
    return {"--follow is for one log in g2o, without --stamps, --gps and --parts"};
  });
  command.check([options] { return check_parts(*options); });
  command.check([&command, options, following] { return check_following(command, *options, *following); });
  command.act([options, following](const std::stop_token& stop) {
    if (is_stdout(following->steps)) options->quiet = true;
    return run_log(*options, *following, stop);
  });
}

}  // namespace mapjoin::apps
