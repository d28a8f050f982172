// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin covariance`: the covariances of named poses and features of a map, together and relative to each other.

#include <fmt/format.h>

#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <apps/names.hpp>
#include <apps/report/report.hpp>
#include <apps/report/table.hpp>
#include <array>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/text_line.hpp>
#include <memory>
#include <tuple>
#include <variant>

namespace mapjoin::apps {
namespace {

struct CovarianceOptions : Options {
  std::vector<std::string> names;
};

/// The least-squares map of the input, with its covariances.
template <int Dim>
RunResult<Dim> solved(const RunOptions& options, const Log<Dim>& log, const std::stop_token& stop) {
  return run(log, options, stop).value();
}
template <int Dim>
RunResult<Dim> solved(const RunOptions& options, SubmapSet<Dim> set, const std::stop_token& stop) {
  return run(std::move(set), options, stop).value();
}
template <int Dim>
RunResult<Dim> solved(const RunOptions& options, StoredMaps<Dim> stored, const std::stop_token& stop) {
  return run_from_maps(stored.log, split_along(stored.log, stored.segments), std::move(stored.maps), options, stop).value();
}

/// One of the poses and features that were named.
template <int Dim>
struct Named {
  PoseOrFeature index;
  std::string text;  ///< "pose 17"
  Json id;
  std::vector<std::string> coordinates;  ///< Names of the coordinates of its step.
  std::vector<Eigen::Index> rows;        ///< Their places in the joint covariance of all.
};

template <int Dim>
std::vector<Named<Dim>> find_all(const CovarianceOptions& options, const GlobalMap<Dim>& map) {
  std::vector<Named<Dim>> all;
  for (const std::string& word : options.names) {
    const PoseOrFeature index = find_named(word, map.pose_ids, map.feature_ids).value();
    if (const auto* pose = std::get_if<PoseIndex>(&index)) {
      all.push_back({index, to_string(map.pose_ids[*pose]), map.pose_ids[*pose], step_names<Dim>(), {}});
    } else {
      const FeatureId id = map.feature_ids[std::get<FeatureIndex>(index)];
      all.push_back({index, to_string(id), id, step_names<Dim>(Dim), {}});
    }
  }
  for (Eigen::Index row = 0; Named<Dim> & one : all) {
    for (std::size_t i = 0; i < one.coordinates.size(); ++i) one.rows.push_back(row++);
  }
  return all;
}

/// The covariance as JSON, a row per coordinate.
Json rows_of(const Eigen::MatrixXd& covariance) {
  Json rows = Json::array();
  for (const auto& row : covariance.rowwise()) rows.push_back(std::vector<double>(row.begin(), row.end()));
  return rows;
}

template <int Dim>
ReportTable table_of(const std::vector<Named<Dim>>& all, const Eigen::MatrixXd& covariance) {
  ReportTable table{{{"covariance", ""}}, {}};
  for (const auto& named : all) {
    for (const std::string& name : named.coordinates)
      table.columns.push_back({named.text + " " + name, named.text + " " + name});
  }
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    Row row{{table.columns[static_cast<std::size_t>(i + 1)].key}};
    for (const double entry : covariance.row(i)) row.cells.emplace_back(entry);
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// The standard deviations in words: "0.12 0.1 m, 0.003 rad".
template <int Dim>
std::string deviations_in_words(const Eigen::MatrixXd& covariance) {
  std::string words;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    words += fmt::format("{:.4g} ", std::sqrt(covariance(i, i)));
    if (i + 1 == Dim) words += covariance.rows() > Dim ? "m, " : "m";
  }
  return covariance.rows() > Dim ? words + "rad" : words;
}

/// A pose or feature in the frame of a pose, with its covariance there.
struct Relation {
  Json json;
  std::string words;
};

template <int Dim>
Relation relation(const MapCovariances<Dim>& covariances, const Named<Dim>& base, const Named<Dim>& target,
                  const Eigen::MatrixXd& joint) {
  std::vector<Eigen::Index> rows = base.rows;
  rows.insert(rows.end(), target.rows.begin(), target.rows.end());
  const PoseIndex from = std::get<PoseIndex>(base.index);
  const Pose<Dim>& frame = covariances.state().poses[from];
  Eigen::MatrixXd covariance;
  Point<Dim> position;
  Json rotation;
  if (const auto* pose = std::get_if<PoseIndex>(&target.index)) {
    const Pose<Dim> value = between(frame, covariances.state().poses[*pose]);
    covariance = covariances.relative_pose(from, *pose, joint(rows, rows));
    position = value.translation;
    const RotationVector<Dim> vector = value.rotation.log();
    rotation = std::vector<double>(vector.begin(), vector.end());
  } else {
    const FeatureIndex feature = std::get<FeatureIndex>(target.index);
    covariance = covariances.relative_feature(from, feature, joint(rows, rows));
    position = transform_into<Dim>(frame, covariances.state().features[feature]);
  }
  return {{{"from", base.id},
           {"to", target.id},
           {"position", std::vector<double>(position.begin(), position.end())},
           {"rotation", rotation},
           {"covariance", rows_of(covariance)}},
          fmt::format("{} from {}: {:.6g} m away, standard deviations {}", target.text, base.text, position.norm(),
                      deviations_in_words<Dim>(covariance))};
}

/// The relations of all pairs with a pose: the later one in the frame of the earlier one, or of the pose if the earlier one is
/// a feature.
template <int Dim>
std::vector<Relation> relations_of(const MapCovariances<Dim>& covariances, const std::vector<Named<Dim>>& all,
                                   const Eigen::MatrixXd& joint) {
  std::vector<Relation> relations;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      const bool is_first_pose = std::holds_alternative<PoseIndex>(all[i].index);
      if (!is_first_pose && !std::holds_alternative<PoseIndex>(all[j].index)) continue;
      const auto& [base, target] = is_first_pose ? std::tie(all[i], all[j]) : std::tie(all[j], all[i]);
      relations.push_back(relation(covariances, base, target, joint));
    }
  }
  return relations;
}

/// The covariances asked for, for programs and for people.
template <int Dim>
struct Answer {
  std::vector<Named<Dim>> named;
  Eigen::MatrixXd joint;
  std::vector<Relation> relations;

  Answer(const CovarianceOptions& options, const RunResult<Dim>& result) : named(find_all(options, result.map)) {
    std::vector<PoseOrFeature> asked;
    for (const auto& one : named) asked.push_back(one.index);
    joint = result.covariances->joint(asked).value();
    relations = relations_of(*result.covariances, named, joint);
  }

  Json json() const {
    Json variables = Json::array();
    for (const auto& one : named) {
      variables.push_back(one.id);
      variables.back()["coordinates"] = one.coordinates;
    }
    Json relative = Json::array();
    for (const Relation& relation : relations) relative.push_back(relation.json);
    return {{"variables", variables}, {"covariance", rows_of(joint)}, {"relations", relative}};
  }

  void add_to(Lines& lines) const {
    for (const auto& one : named) {
      lines.add("in the map", one.text + ": standard deviations " + deviations_in_words<Dim>(joint(one.rows, one.rows)));
    }
    for (const Relation& relation : relations) lines.add("relative", relation.words);
  }
};

template <int Dim>
void tell_covariances(CommandRun& command_run, const CovarianceOptions& options, const RunResult<Dim>& result) {
  RunReport& run_report = command_run.run_report;
  run_report.describe(result);
  if (result.no_covariances) fail(ErrorKind::kBadInput, run_report.input + ": " + result.no_covariances->message);
  const Answer<Dim> answer(options, result);
  Json json = report_head(run_report);
  json["estimate"] = result.covariances->estimate();
  json["gauge"] = {{"held_poses", run_report.anchored}};
  json.update(answer.json());
  Lines lines;
  add_input(run_report, lines, "map");
  lines.add("gauge", gauge_in_words(run_report));
  answer.add_to(lines);
  add_notes(run_report, lines);
  const ReportTable table = table_of(answer.named, answer.joint);
  if (!options.output.empty()) {
    demand(write_file(options.output, csv(table)));
    lines.add("written", options.output.string());
  }
  command_run.tell(text_of(json), lines.text() + "\n" + aligned(table));
}

ExitCode tell(const CovarianceOptions& options, const std::stop_token& stop) {
  CommandRun command_run("covariance", options, stop);
  command_run.prepare(outputs_of(options));
  RunOptions solving = command_run.run_options();
  solving.covariances = true;
  return command_run.with_log_or_maps([&](auto&& input) {
    const auto result = solved(solving, std::move(input), stop);
    tell_covariances(command_run, options, result);
    if (result.converged()) return ExitCode::kDone;
    say(command_run.run_report.input + ": the map did not converge, and these are not the covariances of an optimum");
    return ExitCode::kDidNotConverge;
  });
}

}  // namespace

void declare_covariance(Subcommand& command) {
  command.examples(
      "  mapjoin run data/manhattan2d.g2o -o result\n"
      "  mapjoin covariance result 0 999 feature:1014\n"
      "  mapjoin covariance data/manhattan2d.g2o 998 999 --report - -o joint.csv");
  const auto options = std::make_shared<CovarianceOptions>();
  command.argument(
      "MAP", options->input,
      "The folder of a run, a map with its edges, a log, or local maps: what the covariances are of is solved again");
  command.words("NAME", options->names,
                "Poses and features: 17 or a17 or, where that could be several, pose:17, feature:17, 1:17 (of session 1)");
  command.path("-o,--output", options->output, "FILE",
               "Write the joint covariance as CSV, one line and one column a coordinate");
  add_most_memory(command, *options, "Refuse what would take more [as much as there is]");
  add_reading(command, *options);
  add_inflation(command, *options);
  add_reporting(command, *options);
  command.check([options] { return output_conflicts(inputs_of(*options, "MAP"), outputs_of(*options)); });
  command.act([options](const std::stop_token& stop) { return tell(*options, stop); });
}

}  // namespace mapjoin::apps
