// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin convert`: logs and local maps from one format into another.

#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <apps/picture/plotted_map.hpp>
#include <apps/report/report.hpp>
#include <array>
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/io/store/store.hpp>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin::apps {
namespace {

struct StoreFormat {};
using AnyFormat = std::variant<LogFormat, LocalMapFormat, StoreFormat>;

struct Format {
  std::string word;
  std::string extension;  ///< Extension that asks for it; empty: none does.
  AnyFormat format;
};

/// The formats of logs, then those of local maps.
std::vector<Format> formats() {
  std::vector<Format> all;
  for (const auto& [format, name] : enum_names(LogFormat())) {
    all.push_back({std::string(name), std::string(file_extension(format)), format});
  }
  all.push_back({"maps-mat", "", LocalMapFormat::kMat});
  all.push_back({"maps-text", "", LocalMapFormat::kText});
  all.push_back({"store", ".maps", StoreFormat()});
  return all;
}

struct ConvertOptions : Options {
  std::optional<AnyFormat> format;  ///< Format asked for; if none, that of the output's extension.
};

/// The words or the extensions of all formats that have one.
std::string listed(std::string Format::*part, std::string_view separator) {
  std::vector<std::string> all;
  for (const Format& format : formats()) {
    if (!(format.*part).empty()) all.push_back(format.*part);
  }
  return fmt::format("{}", fmt::join(all, separator));
}

/// The format asked for or, if none was, that of the output's extension; nullopt if that says nothing.
std::optional<AnyFormat> format_of(const ConvertOptions& options) {
  if (options.format) return options.format;
  const std::string extension = extension_of(options.output);
  for (const Format& format : formats()) {
    if (!extension.empty() && extension == format.extension) return format.format;
  }
  return std::nullopt;
}

/// Violations, in words: an output of no format, and an input in the place of an unfinished store.
std::vector<std::string> check_format(const ConvertOptions& options) {
  const std::optional<AnyFormat> format = format_of(options);
  if (!format) {
    return {fmt::format("{}: its name does not say which format it is to have, as {} do; --to does", options.output.string(),
                        listed(&Format::extension, ", "))};
  }
  if (!std::holds_alternative<StoreFormat>(*format)) return {};
  return unfinished_store_conflicts({{"IN", options.input}}, "OUT", options.output);
}

/// Data that the output has no place for, in words.
using Losses = std::vector<std::string>;

template <int Dim>
Losses convert_any(const ConvertOptions& options, AnyFormat asked, Log<Dim> log) {
  const auto* format = std::get_if<LogFormat>(&asked);
  if (!format) fail(ErrorKind::kUsage, options.input.string() + ": local maps of a log are made by `mapjoin build`");
  Losses lost;
  if (needs_values(*format) && log.initial.poses.empty() && !log.odometry().empty()) {
    log.initial.poses = dead_reckoning(log, Table<PoseIndex, Pose<Dim>>(log.poses.size()));
    lost.emplace_back("there are no values: poses are where odometry alone has them");
  }
  for (std::string& loss : losses(log, *format)) lost.push_back(std::move(loss));
  demand(write_log(log, *format, options.output));
  return lost;
}

/// Writes the files of local maps; `are_named` is true if numbers tell their poses as well as names.
template <int Dim>
Losses write_maps(const std::vector<LocalMap<Dim>>& maps, const FeatureIds& features, LocalMapFormat format, bool are_named,
                  const std::filesystem::path& path) {
  OutputFolder folder = OutputFolder::whole(path);
  folder.commit(write_local_maps(maps, features, format, folder.aside("")).value());
  Losses lost;
  if (!are_named) lost.emplace_back("poses are counted, not named");
  if (Dim == 3) lost.emplace_back("rotations and their weights are those of roll, pitch and yaw, rounded");
  if (Dim == 2 && format == LocalMapFormat::kMat) lost.emplace_back("weights are covariances, rounded");
  return lost;
}

template <int Dim>
Losses convert_any(const ConvertOptions& options, AnyFormat asked, const SubmapSet<Dim>& set) {
  if (std::holds_alternative<LogFormat>(asked)) {
    fail(ErrorKind::kUsage, options.input.string() + ": local maps without their log cannot become a log");
  }
  if (const auto* format = std::get_if<LocalMapFormat>(&asked)) {
    return write_maps(set.graph.submaps, set.features, *format, are_counted(set.poses), options.output);
  }
  demand(write_store(set, options.output));
  return {};
}

/// The reason why segments of a store are no local maps, or what may help: the end of a sentence.
template <int Dim>
std::string why_raw(const StoredMaps<Dim>& stored) {
  Table<PoseIndex, bool> is_inside(stored.log.poses.size(), false);
  for (const Segment& segment : stored.segments) {
    for (PoseIndex pose = segment.begin + 1; !segment.is_map && pose < segment.end; ++pose) is_inside[pose] = true;
  }
  const bool is_closed = std::ranges::any_of(
      stored.log.closures(), [&](const auto& closure) { return is_inside[closure.base] || is_inside[closure.target]; });
  return is_closed ? "since closures lead to poses inside of them: these files have place for the ends of maps only"
                   : "for which these files have no place: `mapjoin build --poses-per-map N` with another N may cut the log "
                     "without any";
}

/// Converts the log or the maps of a store.
template <int Dim>
Losses convert_any(const ConvertOptions& options, AnyFormat asked, const StoredMaps<Dim>& stored) {
  const Log<Dim>& log = stored.log;
  const std::vector<LocalMap<Dim>>& maps = stored.maps;
  if (std::holds_alternative<LogFormat>(asked)) return convert_any(options, asked, log);
  const auto* format = std::get_if<LocalMapFormat>(&asked);
  if (!format) fail(ErrorKind::kUsage, options.input.string() + ": it is a store");
  if (maps.size() < stored.segments.size()) {
    const std::size_t raw = stored.segments.size() - maps.size();
    fail(ErrorKind::kUsage, fmt::format("{}: {} of its {} {}, but observations, {}", options.input.string(), raw,
                                        plural(stored.segments.size(), "segment"),
                                        raw == 1 ? "is not a local map" : "are not local maps", why_raw(stored)));
  }
  const bool are_named = are_counted(log.poses) && maps.size() + 1 == log.poses.size();
  Losses lost = write_maps(maps, log.features, *format, are_named, options.output);
  lost.emplace_back("the log that the maps were built from is left out");
  return lost;
}

ExitCode convert_input(const ConvertOptions& options, const std::stop_token& stop) {
  CommandRun command_run("convert", options, stop);
  const AnyFormat format = format_of(options).value();
  if (!std::holds_alternative<LocalMapFormat>(format)) command_run.prepare(outputs_of(options));
  const Losses lost =
      command_run.with_log_or_maps([&](auto&& input) { return convert_any(options, format, std::move(input)); });
  Lines lines;
  add_input(command_run.run_report, lines);
  add_notes(command_run.run_report, lines);
  lines.add("written", options.output.string());
  for (const std::string& loss : lost) lines.add("lost", loss);
  command_run.tell("", lines.text());
  return ExitCode::kDone;
}

}  // namespace

void declare_convert(Subcommand& command) {
  command.examples(
      "  mapjoin convert data/manhattan2d.g2o manhattan.isam\n"
      "  mapjoin build data/manhattan2d.g2o -o manhattan.maps\n"
      "  mapjoin convert manhattan.maps FOLDER --to maps-text");
  const auto options = std::make_shared<ConvertOptions>();
  command.argument("IN", options->input, kLogOrMaps + ", known by its content");
  command.argument("OUT", options->output, "The file, or for maps-mat and maps-text the folder, to write");
  command.option("--to", listed(&Format::word, "|"), "Its format [by its extension: " + listed(&Format::extension, ", ") + "]",
                 [options](const std::string& word) -> std::optional<std::string> {
                   for (const Format& format : formats()) {
                     if (word == format.word) options->format = format.format;
                   }
                   return options->format ? std::nullopt : std::optional("not one of " + listed(&Format::word, "|"));
                 });
  command.flag("--quiet", options->quiet, "No summary");
  add_reading(command, *options);
  add_inflation(command, *options);
  command.check([options] { return output_conflicts({{"IN", options->input}}, {{"OUT", options->output}}); });
  command.check([options] { return check_format(*options); });
  command.act([options](const std::stop_token& stop) { return convert_input(*options, stop); });
}

}  // namespace mapjoin::apps
