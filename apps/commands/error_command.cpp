// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin error`: the errors of a map or a trajectory against the truth.

#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <apps/report/errors.hpp>
#include <apps/report/report.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <memory>
#include <variant>

namespace mapjoin::apps {
namespace {

using AnyMap = std::variant<GlobalMap<2>, GlobalMap<3>>;

struct ErrorCommandOptions : Options {
  std::filesystem::path true_map;
  double most_apart = kMatchingTimes;  ///< Largest difference between matched times of map and truth (s).
  ErrorOptions errors;
};

/// The values of a log as a map.
template <int Dim>
GlobalMap<Dim> map_of(Log<Dim> log) {
  if (log.initial.poses.empty()) {
    fail(ErrorKind::kBadInput,
         log.source + ": gives no values of its poses: a map is expected (`mapjoin run` makes one of a log)");
  }
  GlobalMap<Dim> map;
  map.pose_ids = std::move(log.poses);
  map.poses = std::move(log.initial.poses);
  map.stamps_ns = std::move(log.stamps_ns);
  if (log.initial.features.size() == log.features.size()) {
    map.feature_ids = std::move(log.features);
    map.features = std::move(log.initial.features);
  }
  return map;
}

/// The map in space; a planar one at height 0, as a trajectory in space is read if it is flat.
GlobalMap<3> lifted(const GlobalMap<2>& map) {
  GlobalMap<3> in_space;
  in_space.pose_ids = map.pose_ids;
  in_space.stamps_ns = map.stamps_ns;
  in_space.feature_ids = map.feature_ids;
  for (const Pose<2>& pose : map.poses) in_space.poses.push_back(mapjoin::in_space(pose));
  for (const Point<2>& feature : map.features) in_space.features.emplace_back(feature.x(), feature.y(), 0.0);
  return in_space;
}
GlobalMap<3> lifted(const GlobalMap<3>& map) {
  return map;
}

/// The map that a log gives, in space if the truth is.
AnyMap map_of(AnyLog log, const TruthFile& truth) {
  const auto as_truth_has_it = [&](auto& any) -> AnyMap {
    auto map = map_of(std::move(any));
    return truth.is_in_space() ? AnyMap(lifted(map)) : AnyMap(std::move(map));
  };
  return std::visit(as_truth_has_it, log);
}

/// True if the truth has poses of these names in session 0.
template <int Dim>
bool knows_in_first_session(const TruthFile& truth, const GlobalMap<Dim>& map) {
  PoseIds names = map.pose_ids;
  for (PoseId& name : names) name.session = 0;
  const auto poses = truth.of<Dim>(names, {}, map.stamps_ns).poses;
  return std::ranges::any_of(poses, [](const auto& pose) { return pose.has_value(); });
}

/// Why nothing can be measured: the truth has no pose of the map.
std::string why_nothing(const AnyMap& map, const TruthFile& truth) {
  if (std::visit([&](const auto& any) { return knows_in_first_session(truth, any); }, map)) {
    return "names the poses of the map in session 0, and the map in others; a table whose column session says of which "
           "session each pose is matches them";
  }
  if (std::visit([](const auto& any) { return !any.stamps_ns.empty(); }, map)) {
    return "has no pose of the map, neither by name nor by time; --max-time-difference widens the match of times";
  }
  return "has no pose of the map, neither by name nor by count; where it has times, the map needs them, too (`mapjoin run "
         "--stamps`)";
}

ExitCode measure(const ErrorCommandOptions& options, const std::stop_token& stop) {
  CommandRun command_run("error", options, stop);
  command_run.prepare(report_of(options));
  TruthFile truth(options.true_map, options.most_apart, options.read);
  truth.take_map(options.input);
  const AnyMap map = map_of(command_run.read_log(), truth);
  std::visit([&](const auto& any) { command_run.measure(any, truth, options.errors); }, map);
  const TruthErrors& errors = *command_run.run_report.errors;
  if (errors.absolute.poses.translation.count == 0) {
    fail(ErrorKind::kUsage, options.true_map.string() + ": " + why_nothing(map, truth));
  }
  Json json = report_head(command_run.run_report);
  json["truth"] = options.true_map.string();
  json["errors"] = json_of(errors);
  Lines lines;
  add_input(command_run.run_report, lines, "map");
  lines.add("truth", options.true_map.string());
  add_errors(errors, lines);
  add_notes(command_run.run_report, lines);
  command_run.tell(text_of(json), lines.text());
  return ExitCode::kDone;
}

std::optional<double> span_in(const std::string& word) {
  const std::optional<double> span = number_in<double>(word);
  return span && *span > 0.0 ? span : std::nullopt;
}

std::vector<std::string> check_spans(const ErrorOptions& options) {
  for (const double span : options.spans) {
    if (options.unit == SpanUnit::kSteps && (span != std::floor(span) || span > 1e9))
      return {"--spans are whole numbers of steps"};
  }
  return {};
}

}  // namespace

void declare_error(Subcommand& command) {
  command.examples(
      "  mapjoin run data/manhattan2d.g2o -o map.g2o\n"
      "  mapjoin error map.g2o data/manhattan2d.truth.tum\n"
      "  mapjoin error map.g2o data/manhattan2d.truth.tum --spans 10,50 --span-unit metres --pairs successive --report -");
  const auto options = std::make_shared<ErrorCommandOptions>();
  ErrorOptions& errors = options->errors;
  command.argument(
      "MAP", options->input,
      "A map or a trajectory, known by its content: g2o, TORO, TUM, KITTI, or the CSV table of poses; or the folder "
      "of a run");
  command.argument("TRUTH", options->true_map, "The same; poses are matched by their times, by their names, or by their count");
  command.choice("--align", errors.alignment, "Move the map onto the truth: by all positions, by the first pose, or not");
  command.list("--spans", "SPAN,...", "Compare the motions over these spans [1,10,100]", errors.spans, &span_in,
               "not positive numbers with commas between them");
  command.choice("--span-unit", errors.unit, "What spans are counted in; metres along the way of the map");
  command.choice("--pairs", errors.pairs, "Compare motions from every pose on, or one behind the other");
  command.number<double>("--max-time-difference", options->most_apart, 0.0, "S",
                         "Between poses that are matched by their times");
  command.path("--report", options->report, "FILE|-", "Write a report in JSON; with - nothing else goes to standard output");
  command.flag("--quiet", options->quiet, "No summary");
  add_reading(command, *options);
  command.check([&errors] { return check_spans(errors); });
  command.check([options] {
    return output_conflicts({{"MAP", options->input}, {"TRUTH", options->true_map}}, report_of(*options));
  });
  command.act([options](const std::stop_token& stop) { return measure(*options, stop); });
}

}  // namespace mapjoin::apps
