// SPDX-License-Identifier: BSD-3-Clause
// The options that say what is read, and how.
#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/options.hpp>
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/open.hpp>
#include <memory>
#include <optional>
#include <sstream>
#include <vector>

namespace mapjoin::apps {
namespace {

void add_format(Subcommand& command, Options& options) {
  std::vector<std::string_view> names;
  for (const auto& [format, name] : enum_names(LogFormat())) names.push_back(name);
  const std::string words = fmt::format("{}", fmt::join(names, "|"));
  command.option("--from", words, "Take the log as of this format [known by its content]",
                 [&options, words](const std::string& word) -> std::optional<std::string> {
                   const auto all = enum_names(LogFormat());
                   const auto asked = std::ranges::find(all, word, &EnumName<LogFormat>::name);
                   if (asked == all.end()) return "not one of " + words;
                   options.read.from = asked->value;
                   return std::nullopt;
                 });
}

/// A violation, in words: an input that is given twice and would count twice.
std::vector<std::string> check_given_once(const Options& options) {
  std::vector<std::filesystem::path> before = {options.input};
  for (const std::filesystem::path& input : options.further) {
    const auto is_same = [&](const std::filesystem::path& other) {
      std::error_code ignored;
      return std::filesystem::equivalent(other, input, ignored);
    };
    if (std::ranges::any_of(before, is_same)) return {input.string() + " is given twice: leave one out"};
    before.push_back(input);
  }
  return {};
}

/// Refuses an option of logs for local maps, whatever its word: also one that says what would be done anyway.
void refuse_for_maps(Subcommand& command, const Options& options, const std::string& option) {
  command.check([&command, &options, option]() -> std::vector<std::string> {
    if (!command.is_given(option) || !may_hold_maps(options.input)) return {};
    return {is_for_a_log(options.input, option)};
  });
}

/// Takes "closure=3,odometry=1.5"; returns a violation otherwise.
std::optional<std::string> take_inflation(const std::string& words, Inflation& inflation) {
  std::istringstream list(words + ",");
  for (std::string word; std::getline(list, word, ',');) {
    const std::size_t equals = word.find('=');
    const auto kind = std::ranges::find(kInflatedKinds, word.substr(0, equals), &InflatedKind::name);
    const auto factor = equals == word.npos ? std::nullopt : number_in<double>(word.substr(equals + 1));
    if (kind == kInflatedKinds.end() || !factor || !(*factor >= Inflation::kLeast && *factor <= Inflation::kMost)) {
      return fmt::format(
          "not closure=X, odometry=X, observation=X, prior=X or map=X, with X from {:g} to {:g} and commas between them",
          Inflation::kLeast, Inflation::kMost);
    }
    inflation.*kind->factor = *factor;
  }
  return std::nullopt;
}

/// Refuses to inflate what the input does not have, or what gives its standard deviations elsewhere.
std::vector<std::string> check_inflation(const Options& options) {
  if (options.inflation == Inflation{}) return {};
  std::vector<std::string> violations;
  const bool holds_maps = may_hold_maps(options.input);
  for (const auto& [name, factor] : kInflatedKinds) {
    const bool is_of_maps = factor == &Inflation::maps;
    if (options.inflation.*factor == 1.0 || is_of_maps == holds_maps) continue;
    violations.push_back(holds_maps ? is_for_a_log(options.input, fmt::format("--inflate {}", name)) +
                                          ", from which `mapjoin build` makes them"
                                    : options.input.string() + ": is a log, and --inflate map is for local maps");
  }
  if (options.covariance == Covariance::kIdentity) {
    violations.emplace_back("--inflate is of the weights as given, which --covariance identity replaces");
  }
  if (!options.gps.empty() && options.inflation.priors != 1.0) {
    violations.push_back(options.gps.string() + ": says how certain its fixes are, and --inflate prior is for those of a log");
  }
  return violations;
}

}  // namespace

void refuse_weights_of_store() {
  fail(ErrorKind::kUsage,
       "the weights of a store are chosen when it is built: --covariance, --inflate and --repair-information go with `mapjoin "
       "build`");
}

std::string is_for_a_log(const std::filesystem::path& input, const std::string& option) {
  return fmt::format("{}: holds local maps, and {} is for a log", input.string(), option);
}

void add_weights(Subcommand& command, Options& options) {
  command.group("Reading");
  command.choice("--covariance", options.covariance, "Weights as given, or all replaced by the identity of what was measured");
  command.flag(
      "--repair-information", options.read.repair_information,
      "Take the symmetric part of an asymmetric information matrix or covariance and the nearest semidefinite one of an "
      "indefinite one, and count them");
}

void add_inflation(Subcommand& command, Options& options) {
  command.group("Reading");
  command.option("--inflate", "KIND=X,...",
                 "Take the standard deviations of all measurements of a kind (closure, odometry, observation, prior, map) as X "
                 "times what the input says: where they are too small, the verdict says by how much; what is written has these",
                 [&options](const std::string& words) { return take_inflation(words, options.inflation); });
  command.check([&options] { return check_inflation(options); });
}

void add_leniency(Subcommand& command, Options& options, const std::string& of) {
  command.flag("--skip-unknown", options.read.skip_unknown, "Leave out lines of unknown tags" + of);
  command.flag("--skip-self-edges", options.read.skip_self_edges, "Leave out edges from a pose to itself" + of);
  const auto skip = std::make_shared<bool>(false);
  command.flag("--skip-undeclared", *skip, "Leave out lines that name what a file with vertices does not declare" + of);
  command.flag("--identity-where-missing", options.read.identity_where_missing,
               "Take the identity for the weights of edges without any" + of);
  command.check([&options, skip]() -> std::vector<std::string> {
    if (*skip) options.read.undeclared = Undeclared::kSkipped;
    return {};
  });
}

void add_reading(Subcommand& command, Options& options) {
  add_weights(command, options);
  command.choice("--g2o-error", options.read.pose_error,
                 "What a g2o file's pose-pose information weighs: the residual in the frame of the base, or g2o's");
  command.choice("--rotation-information", options.read.rotation_information,
                 "What its rotational part weighs in 3D: the rotation vector (GTSAM, SE-Sync) or the quaternion's (g2o)");
  for (const char* of_g2o : {"--g2o-error", "--rotation-information"}) refuse_for_maps(command, options, of_g2o);
  add_format(command, options);
  add_leniency(command, options, ", and count them");
}

void add_reading_of_truth(Subcommand& command, Options& options) {
  command.group("Reading");
  add_leniency(command, options, " in the truth");
  for (const char* of_truth : {"--skip-unknown", "--skip-self-edges", "--skip-undeclared", "--identity-where-missing"}) {
    command.only_with(of_truth, "--truth", [&options] { return !options.truth.empty(); });
  }
}

void add_further(Subcommand& command, Options& options, const std::string& kind) {
  command.further(options.further, "Further " + kind + ", each a session in a frame and with pose ids of its own");
  command.group("Reading");
  command.choice("--features", options.merging.own_features, std::to_array<EnumName<bool>>({{false, "shared"}, {true, "own"}}),
                 "Whether features of the same id in different " + kind + " are the same");
  command.flag("--keep-copies", options.merging.keep_copies,
               "Edges, or whole " + kind + ", that stand in two files count twice");
  command.check([&command, &options]() -> std::vector<std::string> {
    options.features_undecided = !command.is_given("--features");
    return {};
  });
  command.check([&options] { return check_given_once(options); });
  command.check([&options]() -> std::vector<std::string> {
    if (!options.further.empty()) return {};
    std::vector<std::string> violations;
    const std::string of_store = may_hold_maps(options.input) ? "; inputs of one store take it from `mapjoin build`" : "";
    if (options.merging.own_features) violations.emplace_back("--features own is of several inputs" + of_store);
    if (options.merging.keep_copies) violations.emplace_back("--keep-copies is of several inputs");
    return violations;
  });
}

void add_further_logs(Subcommand& command, Options& options) {
  add_further(command, options, "logs");
  command.path("--stamps", options.stamps, "FILE", "Times of poses: lines of id and time (s)");
  command.flag("--ids-are-nanoseconds", options.ids_are_nanoseconds, "Ids of poses are their times (ns)");
  command.check([&options]() -> std::vector<std::string> {
    if (options.stamps.empty() || !options.ids_are_nanoseconds) return {};
    return {"--stamps and --ids-are-nanoseconds exclude each other"};
  });
}

void add_gps(Subcommand& command, Options& options) {
  command.group("Georeferencing");
  command.path("--gps", options.gps, "FILE",
               "Fixes of a satellite receiver hold the map, which is then east, north and up: CSV with columns time or pose, "
               "latitude, longitude, sd_east, sd_north and, in space, height, sd_up; with --robust wrong ones are left out");
  command.option("--gps-lever", "X,Y[,Z]", "Where the antenna is in the frame of a pose (m), Z in space only [0,0,0]",
                 [&options](const std::string& words) -> std::optional<std::string> {
                   std::istringstream list(words + ",");
                   int count = 0;
                   for (std::string word; std::getline(list, word, ','); ++count) {
                     const auto number = number_in<double>(word);
                     if (!number || count == 3) return "not two or three numbers with commas between them";
                     options.of_gps.lever[count] = *number;
                   }
                   return count < 2 ? std::optional("not two or three numbers with commas between them") : std::nullopt;
                 });
  command.number<double>("--gps-apart", options.of_gps.most_apart, 0.0, "S",
                         "Between a fix and the pose nearest in time; a fix that is farther from one is left out");
  command.check([&options] { return options.of_gps.validate(); });
  for (const char* of_gps : {"--gps-lever", "--gps-apart"}) {
    command.only_with(of_gps, "--gps", [&options] { return !options.gps.empty(); });
  }
}

void add_parts(Subcommand& command, Options& options) {
  command.group("Reading");
  command.choice("--parts", options.parts,
                 "Of a log whose parts nothing ties together: none, the largest, or all (with -o DIR: a folder for each)");
}

void add_one_part(Subcommand& command, Options& options) {
  command.group("Reading");
  command.option("--parts", "refuse|largest",
                 "Of a log whose parts nothing ties together: none, or the largest; `mapjoin run --parts all -o DIR` makes a "
                 "map of each [refuse]",
                 [&options](const std::string& word) -> std::optional<std::string> {
                   if (word == "all") return "which makes a map of each part: it goes with `mapjoin run -o DIR`";
                   if (word != "refuse" && word != "largest") return "not refuse or largest";
                   options.parts = word == "largest" ? Parts::kLargest : Parts::kRefuse;
                   return std::nullopt;
                 });
}

}  // namespace mapjoin::apps
