// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin info`: the content of a file.

#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <apps/report/report.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <memory>
#include <variant>

namespace mapjoin::apps {
namespace {

template <typename Id>
std::string range_of(const std::vector<Id>& ids) {
  if (ids.empty()) return "none";
  const auto [first, last] = std::minmax_element(ids.begin(), ids.end());
  return fmt::format("{}, {} to {}", ids.size(), to_string(*first), to_string(*last));
}

template <int Dim>
std::string values_in_words(const Log<Dim>& log) {
  if (log.initial.poses.empty() || log.initial.features.size() != log.features.size()) return "not of every pose and feature";
  const double chi2 = log_chi2(log, log.initial).total();
  return fmt::format("of every pose and feature, chi2 {:.10g}", chi2);
}

std::string stamps_in_words(const std::vector<std::int64_t>& stamps_ns) {
  if (stamps_ns.empty()) return "none";
  const auto [first, last] = std::ranges::minmax(stamps_ns);
  return fmt::format("{} s to {} s", seconds(first), seconds(last));
}

template <int Dim>
void add_content(const Log<Dim>& log, Lines& lines) {
  lines.add("poses", range_of(log.poses));
  if (!std::ranges::is_sorted(log.poses)) lines.add("order", "that of the edges, which tell it better than the ids of poses");
  lines.add("features", range_of(log.features));
  lines.add("sessions", fmt::format("{}", log.sessions.size()));
  lines.add("odometry", fmt::format("{}", log.odometry().size()));
  lines.add("closures", fmt::format("{}", log.closures().size()));
  lines.add("observations", fmt::format("{}", log.observations().size()));
  lines.add("priors", fmt::format("{} of poses, {} of features", log.pose_priors().size(), log.feature_priors().size()));
  lines.add("fixed poses", fmt::format("{}", log.graph.fixed.size()));
  lines.add("values", values_in_words(log));
  lines.add("stamps", stamps_in_words(log.stamps_ns));
}

template <int Dim>
void add_content(const SubmapSet<Dim>& set, Lines& lines) {
  std::size_t seen = 0;
  for (const LocalMap<Dim>& map : set.graph.submaps) seen += map.features.size();
  lines.add("local maps", fmt::format("{}", set.graph.submaps.size()));
  lines.add("poses", range_of(set.poses));
  lines.add("features", fmt::format("{}; {} in all maps together", range_of(set.features), seen));
}

template <int Dim>
void add_content(const StoredMaps<Dim>& stored, Lines& lines) {
  std::int32_t longest = 0;
  for (const Segment& segment : stored.segments) longest = std::max(longest, segment.end - segment.begin);
  lines.add("local maps", fmt::format("{} of {} of up to {}", stored.maps.size(), plural(stored.segments.size(), "segment"),
                                      plural(longest, "step")));
  if (const Share& share = stored.share; !share.is_whole()) {
    lines.add("part", fmt::format("{} of {}", share.index + 1, share.count));
  }
  lines.add("built by", stored.options);
  lines.add("log", stored.log.source);
  add_content(stored.log, lines);
}

template <typename Content>
std::string described(const RunReport& run_report, const Content& content) {
  constexpr bool kIsLog = requires {
    content.odometry();
  };
  constexpr bool kIsStore = requires {
    content.log;
  };
  Lines lines;
  lines.add("file", run_report.input);
  lines.add("kind", kIsLog ? "log" : kIsStore ? "store of local maps and their log" : "set of local maps");
  lines.add("dimension", fmt::format("{}", run_report.dimension));
  add_content(content, lines);
  add_convention(run_report, lines);
  add_notes(run_report, lines);
  return lines.text();
}

}  // namespace

void declare_info(Subcommand& command) {
  command.examples("  mapjoin info data/manhattan2d.g2o");
  const auto options = std::make_shared<Options>();
  command.argument("FILE", options->input, kLogOrMaps);
  add_further_logs(command, *options);
  add_reading(command, *options);
  command.act([options](const std::stop_token& stop) {
    CommandRun command_run("info", *options, stop);
    const auto text =
        command_run.with_log_or_maps([&](const auto& content) { return described(command_run.run_report, content); });
    command_run.tell("", text);
    return ExitCode::kDone;
  });
}

}  // namespace mapjoin::apps
