// SPDX-License-Identifier: BSD-3-Clause
#include <tbb/info.h>

#include <algorithm>
#include <apps/commands/options.hpp>
#include <mapjoin/io/open.hpp>
#include <memory>
#include <optional>
#include <vector>

namespace mapjoin::apps {
namespace {

constexpr int kMostJobs = 1024;
/// The word of --robust that doubts odometry, too.
constexpr const char* kAll = "all";

const std::vector<std::string> kRules = {"--poses-per-map", "--metres-per-map", "--features-per-map"};

/// A violation, in words, if several rules are given: they exclude each other.
std::vector<std::string> check_one_rule(const Subcommand& command) {
  const auto given = std::count_if(kRules.begin(), kRules.end(), [&](const auto& rule) { return command.is_given(rule); });
  if (given < 2) return {};
  return {"only one of --poses-per-map, --metres-per-map and --features-per-map can say where to cut"};
}

/// Settles the schedule: --start and --batch imply batch, and are violations with a schedule that needs no start. In the
/// relative state, batch is gradual unless --batch or --method is given.
std::vector<std::string> settle_batch(const Subcommand& command, Options& settled) {
  RunOptions& run = settled.run;
  const std::vector<std::string> options = {"--start", "--batch"};
  const auto asked = std::find_if(options.begin(), options.end(), [&](const auto& option) { return command.is_given(option); });
  if (asked != options.end() && !command.is_given("--schedule")) run.schedule = Schedule::kBatch;
  const bool takes_start = rule_of(run.schedule).takes_start();
  const bool is_plain = command.is_given("--method") || run.state == JoinedState::kAbsolute;
  if (!command.is_given("--batch")) run.gradual = takes_start && !is_plain;
  if (takes_start || asked == options.end()) return {};
  return {*asked + " is for --schedule batch: " + to_string(run.schedule) + " needs no initial value"};
}

}  // namespace

std::optional<SplitOptions> split_by_poses(const std::string& word) {
  if (word == "auto") return SplitOptions{};
  const auto poses = number_in<std::int64_t>(word);
  if (!poses || *poses < 1) return std::nullopt;
  return SplitOptions{SplitRule::kPoses, static_cast<double>(*poses)};
}

std::string in_words(const SplitOptions& split) {
  if (split.rule == SplitRule::kAuto) return "auto";
  const char* const unit = split.rule == SplitRule::kDistance ? " m" : split.rule == SplitRule::kFeatures ? " features" : "";
  return fmt::format("{:g}{}", split.amount, unit);
}

std::string no_map_in_words(const SplitOptions& split) {
  return fmt::format(
      "maps of {}: this cuts the log into no local map, so that joining is full SLAM once more; "
      "another --poses-per-map N may cut it",
      in_words(split));
}

std::size_t thread_count(const Options& options) {
  return static_cast<std::size_t>(options.jobs > 0 ? options.jobs : tbb::info::default_concurrency());
}

void add_splitting(Subcommand& command, Options& options) {
  SplitOptions& split = options.run.split;
  command.group("Local maps");
  command.option("--poses-per-map", "N|auto", "Cut after so many poses; auto: where a cost model finds it cheapest [auto]",
                 [&split](const std::string& word) -> std::optional<std::string> {
                   const auto asked = split_by_poses(word);
                   if (!asked) return "not auto or a whole number from 1 on";
                   split = *asked;
                   return std::nullopt;
                 });
  const auto rule = [&](const std::string& name, SplitRule by, const std::string& kind, const std::string& help) {
    command.option(name, kind, help, [&split, by](const std::string& word) -> std::optional<std::string> {
      const std::optional<double> amount = number_in<double>(word);
      if (!amount) return "not a number";
      const SplitOptions asked{by, *amount};
      if (const auto violations = asked.validate(); !violations.empty()) return "but " + violations.front();
      split = asked;
      return std::nullopt;
    });
  };
  rule("--metres-per-map", SplitRule::kDistance, "METRES", "Cut after so many metres travelled");
  rule("--features-per-map", SplitRule::kFeatures, "N", "Cut after so many different features seen");
  command.check([&command] { return check_one_rule(command); });
}

void add_share(Subcommand& command, Options& options) {
  command.group("Local maps");
  add_part(command,
           "Build the K-th of N parts of the local maps, here or on another machine; `mapjoin join` unites the stores of all "
           "parts",
           [&options](std::size_t part, std::size_t count) {
             options.share = {part - 1, count};
           });
}

void add_schedule(Subcommand& command, Options& options) {
  command.group("Joining");
  command.choice(
      "--schedule", options.run.schedule,
      "In which order: neighbours in pairs, then pairs of pairs, each pair solved (tree) or only placed (aligned); in unequal "
      "pairs, nearly map by map (unbalanced); map by map; or all at once. auto: aligned, and where that was far from linear, "
      "tree and unbalanced, too, until two agree",
      {{"leaning", "unbalanced"}});
  command.choice("--state", options.run.state,
                 "Coordinates of the steps: positions in the map, or each relative to where it hangs");
  command.choice("--start", options.run.start,
                 "What to join all at once from: odometry or maps composed, zeros, random values, or those in the file");
  command.choice("--batch", options.run.gradual, std::to_array<EnumName<bool>>({{false, "direct"}, {true, "gradual"}}),
                 "All observations whole from the start, or what is not quadratic in the relative state brought in "
                 "gradually; the latter with --state relative, unless there is a --method");
  command.number<std::uint64_t>("--seed", options.run.seed, 0, "N", "Of the random start");
  command.check([&command, &options] { return settle_batch(command, options); });
  command.only_with("--seed", "--start random", [&options] { return options.run.start == Start::kRandom; });
}

std::vector<std::string> check_uncut(const Subcommand& command, const Options& options) {
  const auto given = std::ranges::find_if(kRules, [&](const std::string& rule) { return command.is_given(rule); });
  const bool is_part = options.share.count > 1;
  if ((given == std::end(kRules) && !is_part) || !may_hold_maps(options.input)) return {};
  if (given != std::end(kRules)) return {*given + " is for a log: local maps are cut already"};
  return {"--part is for a log: local maps are built already"};
}

void add_polish(Subcommand& command, Options& options) {
  command.group("Joining");
  command.refusal("--no-polish", options.run.polish, "Stop at the joined and recovered map");
}

void add_solver(Subcommand& command, Options& options) {
  MinimiseOptions& solver = options.run.solver;
  command.group("Joining");
  command.choice("--method", solver.method,
                 "Steps: Powell's dogleg, Levenberg-Marquardt, or plain Gauss-Newton, which may diverge");
  command.number("--max-iterations", solver.max_iterations, 1, "N", "At most so many steps of every solve");
}

void add_engine(Subcommand& command, Options& options) {
  command.group("Joining");
  command.choice("--engine", options.run.solver.engine,
                 "What factorises: mapjoin's tree of fronts, or SuiteSparse's CHOLMOD (on one thread) to compare with");
}

void add_verdict(Subcommand& command, Options& options) {
  options.run.verdict = true;
  command.group("Certainty");
  command.refusal("--no-verdict", options.run.verdict, "Do not test whether the map fits what was measured");
  command.flag("--strict", options.strict, "Exit with 7 where the map does not fit, or nothing tells whether it does");
  command.check([&options]() -> std::vector<std::string> {
    if (!options.strict || options.run.verdict) return {};
    return {"--strict goes by the verdict, which --no-verdict leaves out"};
  });
}

void add_association(Subcommand& command, Options& options) {
  command.group("Association");
  const auto wanted = std::make_shared<bool>(false);
  const auto method = std::make_shared<AssociationMethod>(AssociationOptions().method);
  command.flag(
      "--associate", *wanted,
      "Find out which features are the same, whatever their ids say (with --features own only those of different inputs), and "
      "where inputs lie whose frames are unknown: associations.csv in the folder, or beside the map");
  command.choice(
      "--association", *method,
      "How --associate does it: whole sets by joint compatibility (jcbb), or each feature with its nearest neighbour "
      "within a gate (nn), to compare with");
  command.only_with("--association", "--associate", [wanted] { return *wanted; });
  command.check([&options, wanted, method]() -> std::vector<std::string> {
    if (!*wanted) return {};
    options.association.emplace() = {.confidence = options.confidence,
                                     .method = *method,
                                     .names_hold = options.merging.own_features && !options.further.empty(),
                                     .progress = nullptr};
    return options.association->validate();
  });
}

void add_robust(Subcommand& command, Options& options, const std::string& told) {
  command.group("Outliers");
  command.flag("--robust",
               "Find closures, observations and features of local maps that contradict the others, and leave them out: " +
                   told + "; --robust=all doubts the odometry of a log, too",
               [&options](const std::string& word) -> std::optional<std::string> {
                 if (!word.empty() && word != kAll) return "but takes the word all, or none";
                 options.robust.emplace().odometry = word == kAll;
                 return std::nullopt;
               });
  command.check([&options]() -> std::vector<std::string> {
    if (!options.robust) return {};
    std::error_code ignored;
    const bool is_apart = options.input == kAll || std::ranges::find(options.further, kAll) != options.further.end();
    if (is_apart && !std::filesystem::exists(kAll, ignored)) return {"--robust takes its word behind =: --robust=all"};
    options.robust->confidence = options.confidence;
    return options.robust->validate();
  });
}

void add_confidence(Subcommand& command, Options& options, const std::string& of) {
  std::string help;
  if (of.find("--robust") != std::string::npos) {
    help = "With this probability --robust rejects nothing that is right in the whole log";
  }
  if (of.find("--associate") != std::string::npos) {
    help += help.empty() ? "--associate takes" : ", and --associate takes";
    help += " features for the same that are so at least this probably";
  }
  command.number<double>("--confidence", options.confidence, 0.0, "P", help + ", below 1");
  command.only_with("--confidence", of, [&options] { return options.robust || options.association; });
}

void add_certainty(Subcommand& command, Options& options) {
  command.group("Certainty");
  command.flag("--covariances", options.covariances, "Write the covariance of every pose and feature: CSV columns, and JSON");
  command.flag(
      "--relations", options.relations,
      "Write each pose and feature relative to the pose it was measured from, with how certain that is: relations.csv");
  command.path("--truth", options.truth, "FILE",
               "Weigh the errors against this map by their covariances (NEES): " + kTruthFiles +
                   "; in the frame of the fixes or priors where these hold the map");
  add_most_memory(command, options, "For covariances, which are refused where they take more [as much as there is]");
  command.only_with("--max-memory", "--covariances, --relations and --truth",
                    [&options] { return options.covariances || options.relations || !options.truth.empty(); });
}

void add_most_memory(Subcommand& command, Options& options, const std::string& help) {
  constexpr double kByte = 1e-6;
  command.number<double>("--max-memory", options.most_memory_mb, kByte, "MB", help);
}

void add_running(Subcommand& command, Options& options) {
  command.group("Running and reporting");
  command.number<int>(
      "--jobs", options.jobs, 1, "N",
      "Threads; the result is the same for any number" + std::string(options.jobs == 0 ? " [all processors]" : ""), kMostJobs);
  command.flag("--quiet", options.quiet, "No summary and no progress");
}

void add_reporting(Subcommand& command, Options& options) {
  add_running(command, options);
  command.path("--report", options.report, "FILE|-", "Write a report in JSON; with - nothing else goes to standard output");
}

}  // namespace mapjoin::apps
