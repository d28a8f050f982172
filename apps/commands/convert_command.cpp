// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin convert`: logs and local maps from one format into another.

#include <fmt/format.h>

#include <apps/commands/command_run.hpp>
#include <apps/commands/commands.hpp>
#include <apps/console.hpp>
#include <apps/map_file.hpp>
#include <apps/output_conflicts.hpp>
#include <apps/output_folder.hpp>
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

constexpr const char* kExamples =
    "  mapjoin convert data/manhattan2d.g2o manhattan.isam\n"
    "  mapjoin convert VicPark_clean_data.mat vicpark.g2o\n"
    "  mapjoin convert MRCLAM_Dataset6 robots.g2o\n"
    "  mapjoin convert localmaps_mat.tar.gz FOLDER --to maps-text";

enum class MapsFormat : std::uint8_t { kMat, kText, kStore };
using AnyFormat = std::variant<LogFormat, MapsFormat>;

struct Format {
  std::string word;
  std::string extension;  ///< That asks for it; empty: none does.
  AnyFormat format;
};

/// Those of logs, then those of local maps.
std::vector<Format> formats() {
  std::vector<Format> all;
  for (const auto& [format, name] : enum_names(LogFormat())) {
    all.push_back({std::string(name), std::string(file_extension(format)), format});
  }
  all.push_back({"maps-mat", "", MapsFormat::kMat});
  all.push_back({"maps-text", "", MapsFormat::kText});
  all.push_back({"store", ".maps", MapsFormat::kStore});
  return all;
}

struct ConvertOptions : Options {
  std::optional<AnyFormat> format;  ///< As asked for, else by the output's extension.
};

tl::unexpected<Error> misused(std::string message) {
  return tl::unexpected(Error{ErrorKind::kUsage, std::move(message)});
}

std::string words() {
  std::vector<std::string> all;
  for (const Format& format : formats()) all.push_back(format.word);
  return fmt::format("{}", fmt::join(all, "|"));
}

std::string extensions() {
  std::vector<std::string> all;
  for (const Format& format : formats()) {
    if (!format.extension.empty()) all.push_back(format.extension);
  }
  return fmt::format("{}", fmt::join(all, ", "));
}

Expected<AnyFormat> format_of(const ConvertOptions& options) {
  if (options.format) return *options.format;
  const std::string extension = extension_of(options.output);
  for (const Format& format : formats()) {
    if (!extension.empty() && extension == format.extension) return format.format;
  }
  return misused(fmt::format("{}: its name does not say which format it is to have, as {} do; --to does",
                             options.output.string(), extensions()));
}

Expected<ExitCode> tell(CommandRun& command_run, const std::vector<std::string>& lost) {
  command_run.close_progress();
  if (command_run.options().quiet) return ExitCode::kDone;
  Lines lines;
  lines.add("input", fmt::format("{}: {}", command_run.run_report.input, counts_in_words(command_run.run_report)));
  for (const std::string& remark : remarks(command_run.run_report)) lines.add("note", remark);
  lines.add("written", command_run.options().output.string());
  for (const std::string& loss : lost) lines.add("lost", loss);
  return write_stdout(lines.text()).map([] { return ExitCode::kDone; });
}

template <int Dim>
Expected<ExitCode> convert_log(CommandRun& command_run, AnyFormat asked, Log<Dim> log) {
  const auto* format = std::get_if<LogFormat>(&asked);
  if (!format) return misused(fmt::format("{}: local maps of a log are made by `mapjoin build`", command_run.run_report.input));
  std::vector<std::string> lost;
  if (needs_values(*format) && log.initial.poses.empty() && !log.odometry().empty()) {
    log.initial.poses = dead_reckoning(log, std::vector<Pose<Dim>>(log.poses.size()));
    lost.emplace_back("there are no values: poses are where odometry alone has them");
  }
  for (std::string& loss : losses(log, *format)) lost.push_back(std::move(loss));
  if (auto written = write_log(log, *format, command_run.options().output); !written) return tl::unexpected(written.error());
  return tell(command_run, lost);
}

template <int Dim>
Expected<void> write_folder(const std::vector<LocalMap<Dim>>& maps, const std::vector<FeatureId>& features, MapsFormat format,
                            const std::filesystem::path& path) {
  auto folder = OutputFolder::create_whole(path);
  if (!folder) return tl::unexpected(folder.error());
  const auto file_format = format == MapsFormat::kText ? LocalMapFormat::kText : LocalMapFormat::kMat;
  const auto names = write_local_maps(maps, features, file_format, folder->aside(""));
  if (!names) return tl::unexpected(names.error());
  return folder->commit(*names);
}

template <int Dim>
std::vector<std::string> losses_of_maps(MapsFormat format, bool poses_are_counted) {
  std::vector<std::string> lost;
  if (format == MapsFormat::kStore) return lost;
  if (!poses_are_counted) lost.emplace_back("poses are counted, not named");
  if (Dim == 3) lost.emplace_back("rotations and their weights are those of roll, pitch and yaw, rounded");
  if (Dim == 2 && format == MapsFormat::kMat) lost.emplace_back("weights are covariances, rounded");
  return lost;
}

template <int Dim>
Expected<ExitCode> convert_maps(CommandRun& command_run, AnyFormat asked, const MapSet<Dim>& set) {
  const auto* format = std::get_if<MapsFormat>(&asked);
  if (!format)
    return misused(fmt::format("{}: local maps without their log cannot become a log", command_run.run_report.input));
  const auto written = *format == MapsFormat::kStore
                           ? write_store(set, command_run.options().output)
                           : write_folder(set.graph.submaps, set.features, *format, command_run.options().output);
  if (!written) return tl::unexpected(written.error());
  return tell(command_run, losses_of_maps<Dim>(*format, are_counted(set.poses)));
}

/// A store's log, or its maps.
template <int Dim>
Expected<ExitCode> convert_maps(CommandRun& command_run, AnyFormat asked, const StoredMaps<Dim>& stored) {
  const auto* format = std::get_if<MapsFormat>(&asked);
  if (!format) return convert_log(command_run, asked, stored.log);
  if (*format == MapsFormat::kStore) return misused(fmt::format("{}: it is a store", command_run.run_report.input));
  if (stored.maps.size() < stored.stretches.size()) {
    return misused(fmt::format("{}: {} of its {} stretches are not local maps, but observations", command_run.run_report.input,
                               stored.stretches.size() - stored.maps.size(), stored.stretches.size()));
  }
  auto written = write_folder(stored.maps, stored.log.features, *format, command_run.options().output);
  if (!written) return tl::unexpected(written.error());
  auto lost = losses_of_maps<Dim>(*format, are_counted(stored.log.poses) && stored.maps.size() + 1 == stored.log.poses.size());
  lost.emplace_back("the log that the maps were built from is left out");
  return tell(command_run, lost);
}

Expected<ExitCode> convert_input(const ConvertOptions& options, const std::stop_token& stop) {
  CommandRun command_run("convert", options, stop);
  const auto format = format_of(options);
  if (!format) return tl::unexpected(format.error());
  const bool is_folder = std::holds_alternative<MapsFormat>(*format) && std::get<MapsFormat>(*format) != MapsFormat::kStore;
  if (!is_folder) {
    if (auto writable = check_writable(options.output); !writable) return tl::unexpected(writable.error());
  }
  if (may_hold_maps(options.input)) {
    return command_run.read_maps().and_then([&](AnyMaps maps) {
      return std::visit([&](const auto& of_kind) { return convert_maps(command_run, *format, of_kind); }, maps);
    });
  }
  return command_run.read_log().and_then([&](AnyLog log) {
    return std::visit([&](auto& of_dim) { return convert_log(command_run, *format, std::move(of_dim)); }, log);
  });
}

void declare(Subcommand& command) {
  const auto options = std::make_shared<ConvertOptions>();
  command.argument("IN", options->input, "A log, a store, or a folder or archive of local maps, known by its content");
  command.argument("OUT", options->output, "The file, or for maps-mat and maps-text the folder, to write");
  command.option("--to", words(), "Its format [by its extension: " + extensions() + "]",
                 [options](const std::string& word) -> std::optional<std::string> {
                   for (const Format& format : formats()) {
                     if (word == format.word) options->format = format.format;
                   }
                   return options->format ? std::nullopt : std::optional(fmt::format("not one of {}", words()));
                 });
  command.flag("--quiet", options->quiet, "No summary");
  add_reading(command, *options);
  command.check([options] { return output_conflicts({{"IN", options->input}, {"OUT", options->output}}); });
  command.act([options](const std::stop_token& stop) { return convert_input(*options, stop); });
}

}  // namespace

std::unique_ptr<Subcommand> convert_command(CLI::App& app) {
  return std::make_unique<Subcommand>(app, "convert", "A log or local maps in another format", kExamples, declare);
}

}  // namespace mapjoin::apps
