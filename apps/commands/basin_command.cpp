// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin basin`: the experiment of the paper's Table I.

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/commands/commands.hpp>
#include <apps/commands/study.hpp>
#include <apps/output_conflicts.hpp>
#include <apps/report/basin_report.hpp>
#include <memory>
#include <optional>
#include <variant>

namespace mapjoin::apps {
namespace {

constexpr const char* kExamples =
    "  mapjoin basin data/manhattan2d.g2o\n"
    "  mapjoin basin data/manhattan2d.g2o --poses-per-map 10,20,35,60 --seeds 5 -o basin";

const std::vector<std::string> kFiles = {"basin.csv", "basin.json"};

struct BasinRequest {
  Options shared;
  BasinOptions basin;
};

/// Numbers of poses, or "auto", between commas.
std::optional<std::string> take_splits(const std::string& words, std::vector<SplitOptions>& splits) {
  splits.clear();
  for (const std::string& word : words_between_commas(words)) {
    const std::optional<int> poses = number_in<int>(word);
    if (word != "auto" && (!poses || *poses < 1)) return "not auto, nor whole numbers from 1 on with commas between them";
    const SplitOptions split = word == "auto" ? SplitOptions{} : SplitOptions{SplitRule::kPoses, static_cast<double>(*poses)};
    const auto is_same = [&](const SplitOptions& other) { return other.rule == split.rule && other.amount == split.amount; };
    if (std::none_of(splits.begin(), splits.end(), is_same)) splits.push_back(split);
  }
  return std::nullopt;
}

template <int Dim>
Expected<Basin> basin_of(const StoredMaps<Dim>& stored, const BasinOptions& options, const std::stop_token& stop) {
  return basin(stored.log, split_along(stored.log, stored.stretches), options, stop);
}
template <typename Data>
Expected<Basin> basin_of(const Data& data, const BasinOptions& options, const std::stop_token& stop) {
  return basin(data, options, stop);
}

StudyOutput output_of(const Basin& basin, const RunReport& run_report) {
  const std::string json = basin_json(basin, run_report);
  return {basin_table(basin, run_report), json, {{kFiles[0], basin_csv(basin)}, {kFiles[1], json}}};
}

Expected<ExitCode> run_basin(const BasinRequest& asked, const std::stop_token& stop) {
  CommandRun command_run("basin", asked.shared, stop);
  BasinOptions options = asked.basin;
  options.progress = command_run.progress("solves");
  return run_study(
      command_run, [&](const auto& data) { return basin_of(data, options, stop); },
      [&](const Basin& found) { return output_of(found, command_run.run_report); });
}

void declare(Subcommand& command) {
  const auto asked = std::make_shared<BasinRequest>();
  Options& options = asked->shared;
  BasinOptions& basin = asked->basin;
  command.argument("LOG|MAPS", options.input, "A log; or a store, or a folder or archive of local maps");
  command.path("-o,--output", options.output, "DIR", "Write basin.csv and basin.json into this folder");
  command.group("Experiment");
  command.option("--poses-per-map", "N|auto,...", "Lengths of the local maps to join, of a log [auto]",
                 [&basin](const std::string& words) { return take_splits(words, basin.splits); });
  command.number<int>("--seeds", basin.seeds, 1, "N", "Random starts per cell [" + std::to_string(basin.seeds) + "]");
  command.number<int>(
      "--max-iterations", basin.max_iterations, 1, "N",
      "At most so many steps of every solve, where gradual of its last one [" + std::to_string(basin.max_iterations) + "]");
  add_reading(command, options);
  add_reporting(command, options);
  command.check([asked, &command] { return check_uncut(command, asked->shared); });
  command.check([asked] { return output_conflicts(files_of_folder(asked->shared, "LOG|MAPS", kFiles)); });
  command.act([asked](const std::stop_token& stop) { return run_basin(*asked, stop); });
}

}  // namespace

std::unique_ptr<Subcommand> basin_command(CLI::App& app) {
  return std::make_unique<Subcommand>(app, "basin",
                                      "From which starts the optimum is reached: full SLAM and joining, absolute and relative",
                                      kExamples, declare);
}

}  // namespace mapjoin::apps
