// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin convexity`: how far from convex and from linear full SLAM and joining are (paper's Fig. 4, V and VI).

#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <memory>
#include <variant>

namespace mapjoin::apps {
namespace {

constexpr const char* kExamples =
    "  mapjoin convexity data/manhattan2d.g2o -o convexity\n"
    "  mapjoin convexity data/manhattan2d.g2o --states drift --spread 0.5 --to-best --pairs 20";

struct ConvexityRequest {
  Options shared;
  ConvexityOptions convexity;
};

template <int Dim>
Expected<Convexity> convexity_of(const StoredMaps<Dim>& stored, const ConvexityOptions& options, const std::stop_token& stop) {
  return convexity(stored.log, split_along(stored.log, stored.segments), stored.maps, options, stop);
}
template <typename Data>
Expected<Convexity> convexity_of(const Data& data, const ConvexityOptions& options, const std::stop_token& stop) {
  return convexity(data, options, stop);
}

ExitCode run_convexity(const ConvexityRequest& asked, const std::stop_token& stop) {
  CommandRun command_run("convexity", asked.shared, stop);
  auto folder = output_folder(asked.shared.output).value();
  command_run.prepare(report_of(asked.shared));
  ConvexityOptions options = asked.convexity;
  options.split = asked.shared.run.split;
  options.progress = command_run.progress().count("lines");
  const Convexity found =
      command_run.with_log_or_maps([&](const auto& data) { return convexity_of(data, options, stop).value(); });
  command_run.check_interrupted();
  command_run.hand_over(convexity_output(found, options, command_run.run_report), folder);
  return ExitCode::kDone;
}

void add_lines(Subcommand& command, ConvexityOptions& convexity) {
  command.group("Lines of states");
  command.choice("--states", convexity.source,
                 "Random states: positions uniform over the bounding box of the composed start and rotations uniform; or "
                 "composed, odometry and first observations, from measurements with errors of their own covariance");
  command.number<double>("--spread", convexity.spread, 1e-9, "X", "With drift: so many times those errors", 1e9);
  command.flag("--to-best", convexity.to_best, "From random states to the best estimate, not to other random states");
  command.number<std::size_t>("--pairs", convexity.pairs, 1, "N", "Pairs of states", 10'000);
  command.number<std::size_t>("--points", convexity.points, 3, "N", "Values of lambda from 0 to 1", 100'001);
  command.number<std::uint64_t>("--seed", convexity.seed, 0, "N", "The same seed gives the same states");
}

}  // namespace

void declare_convexity(Subcommand& command) {
  command.examples(kExamples);
  const auto asked = std::make_shared<ConvexityRequest>();
  Options& options = asked->shared;
  command.argument("LOG|MAPS", options.input, "A log; or a store, or a folder or archive of local maps");
  command.path("-o,--output", options.output, "DIR", "Write curves.csv and convexity.json into this folder");
  add_lines(command, asked->convexity);
  add_splitting(command, options);
  add_reading(command, options);
  add_reporting(command, options);
  command.check([asked, &command] { return check_uncut(command, asked->shared); });
  command.check([asked] {
    return output_conflicts(inputs_of(asked->shared, "LOG|MAPS"),
                            outputs_of_folder(asked->shared, {"curves.csv", "convexity.json"}));
  });
  command.act([asked](const std::stop_token& stop) { return run_convexity(*asked, stop); });
}

}  // namespace mapjoin::apps
