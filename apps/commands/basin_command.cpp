// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin basin`: the experiment of the paper's Table I.

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <memory>
#include <optional>
#include <variant>

namespace mapjoin::apps {
namespace {

constexpr const char* kExamples =
    "  mapjoin basin data/manhattan2d.g2o --seeds 3\n"
    "  mapjoin basin data/manhattan2d.g2o --poses-per-map 20,60 --seeds 2 -o basin";

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
  return basin(stored.log, split_along(stored.log, stored.segments), options, stop);
}
template <typename Data>
Expected<Basin> basin_of(const Data& data, const BasinOptions& options, const std::stop_token& stop) {
  return basin(data, options, stop);
}

ExitCode run_basin(const BasinRequest& asked, const std::stop_token& stop) {
  CommandRun command_run("basin", asked.shared, stop);
  auto folder = output_folder(asked.shared.output).value();
  command_run.prepare(report_of(asked.shared));
  BasinOptions options = asked.basin;
  options.progress = command_run.progress().count("solves");
  const Basin found = command_run.with_log_or_maps([&](const auto& data) { return basin_of(data, options, stop).value(); });
  command_run.check_interrupted();
  command_run.hand_over(basin_output(found, command_run.run_report), folder);
  return ExitCode::kDone;
}

}  // namespace

void declare_basin(Subcommand& command) {
  command.examples(kExamples);
  const auto asked = std::make_shared<BasinRequest>();
  Options& options = asked->shared;
  BasinOptions& basin = asked->basin;
  command.argument("LOG|MAPS", options.input, "A log; or a store, or a folder or archive of local maps");
  command.path("-o,--output", options.output, "DIR", "Write basin.csv and basin.json into this folder");
  command.group("Experiment");
  command.option("--poses-per-map", "N|auto,...", "Lengths of the local maps to join, of a log [auto]",
                 [&basin](const std::string& words) { return take_splits(words, basin.splits); });
  command.number("--seeds", basin.seeds, 1, "N", "Random starts per cell");
  command.number("--max-iterations", basin.max_iterations, 1, "N",
                 "At most so many steps of every solve, where gradual of its last one");
  add_reading(command, options);
  add_reporting(command, options);
  command.check([asked, &command] { return check_uncut(command, asked->shared); });
  command.check([asked] {
    return output_conflicts(inputs_of(asked->shared, "LOG|MAPS"),
                            outputs_of_folder(asked->shared, {"basin.csv", "basin.json"}));
  });
  command.act([asked](const std::stop_token& stop) { return run_basin(*asked, stop); });
}

}  // namespace mapjoin::apps
