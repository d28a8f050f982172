// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin convexity`: how far from convex and from linear full SLAM and joining are (paper's Fig. 4, V and VI).

#include <fmt/format.h>

#include <apps/commands/command_run.hpp>
#include <apps/commands/commands.hpp>
#include <apps/commands/study.hpp>
#include <apps/output_conflicts.hpp>
#include <apps/report/convexity_report.hpp>
#include <memory>
#include <variant>

namespace mapjoin::apps {
namespace {

constexpr const char* kExamples =
    "  mapjoin convexity data/manhattan2d.g2o -o convexity\n"
    "  mapjoin convexity data/manhattan2d.g2o --states drift --spread 0.5 --to-best --pairs 20";

const std::vector<std::string> kFiles = {"curves.csv", "convexity.json"};

struct ConvexityRequest {
  Options shared;
  ConvexityOptions convexity;
};

template <int Dim>
Expected<Convexity> convexity_of(const StoredMaps<Dim>& stored, const ConvexityOptions& options, const std::stop_token& stop) {
  return convexity(stored.log, split_along(stored.log, stored.stretches), stored.maps, options, stop);
}
template <typename Data>
Expected<Convexity> convexity_of(const Data& data, const ConvexityOptions& options, const std::stop_token& stop) {
  return convexity(data, options, stop);
}

StudyOutput output_of(const Convexity& found, const ConvexityOptions& options, const RunReport& run_report) {
  const std::string json = convexity_json(found, options, run_report);
  return {convexity_table(found, options, run_report), json, {{kFiles[0], convexity_csv(found)}, {kFiles[1], json}}};
}

Expected<ExitCode> run_convexity(const ConvexityRequest& asked, const std::stop_token& stop) {
  CommandRun command_run("convexity", asked.shared, stop);
  ConvexityOptions options = asked.convexity;
  options.split = asked.shared.run.split;
  options.progress = command_run.progress("lines");
  return run_study(
      command_run, [&](const auto& data) { return convexity_of(data, options, stop); },
      [&](const Convexity& found) { return output_of(found, options, command_run.run_report); });
}

void add_lines(Subcommand& command, ConvexityOptions& convexity) {
  command.group("Lines of states");
  command.choice("--states", convexity.source,
                 "Random states: positions uniform over the bounding box of the composed start and rotations uniform; or "
                 "composed, odometry and first observations, from measurements with errors of their own covariance");
  command.number<double>("--spread", convexity.spread, 1e-9, "X", "With drift: so many times those errors [1]", 1e9);
  command.flag("--to-best", convexity.to_best, "From random states to the best estimate, not to other random states");
  command.number<std::size_t>("--pairs", convexity.pairs, 1, "N", fmt::format("Pairs of states [{}]", convexity.pairs), 10'000);
  command.number<std::size_t>("--points", convexity.points, 3, "N",
                              fmt::format("Values of lambda from 0 to 1 [{}]", convexity.points), 100'001);
  command.number<std::uint64_t>("--seed", convexity.seed, 0, "N",
                                fmt::format("The same seed gives the same states [{}]", convexity.seed));
}

void declare(Subcommand& command) {
  const auto asked = std::make_shared<ConvexityRequest>();
  Options& options = asked->shared;
  command.argument("LOG|MAPS", options.input, "A log; or a store, or a folder or archive of local maps");
  command.path("-o,--output", options.output, "DIR", "Write curves.csv and convexity.json into this folder");
  add_lines(command, asked->convexity);
  add_splitting(command, options);
  add_reading(command, options);
  add_reporting(command, options);
  command.check([asked, &command] { return check_uncut(command, asked->shared); });
  command.check([asked] { return output_conflicts(files_of_folder(asked->shared, "LOG|MAPS", kFiles)); });
  command.act([asked](const std::stop_token& stop) { return run_convexity(*asked, stop); });
}

}  // namespace

std::unique_ptr<Subcommand> convexity_command(CLI::App& app) {
  return std::make_unique<Subcommand>(app, "convexity",
                                      "How far from convex and from linear: full SLAM and joining, absolute and relative",
                                      kExamples, declare);
}

}  // namespace mapjoin::apps
