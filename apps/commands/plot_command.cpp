// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin plot`: pictures of maps, logs and local maps.

#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <apps/picture/load.hpp>
#include <apps/picture/picture.hpp>
#include <apps/picture/plotted_map.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

namespace mapjoin::apps {
namespace {

struct PlotOptions : Options {
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path truth_of_first;  ///< Truth of the first map; empty: none.
  bool align = true;
};

bool is_page(const PlotOptions& options) {
  return extension_of(options.output) == ".html";
}

/// Names that tell the maps apart: those of their files, with their folders if these are the same.
std::vector<std::string> names_of(const std::vector<std::filesystem::path>& paths) {
  std::vector<std::string> files;
  for (const auto& path : paths) files.push_back((path.has_filename() ? path : path.parent_path()).filename().string());
  std::vector<std::string> names;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    names.push_back(std::count(files.begin(), files.end(), files[k]) > 1 ? paths[k].string() : files[k]);
  }
  return names;
}

/// Loads all maps; says what is wrong with a joined one, and gives its exit code.
AnyScene load_all(const PlotOptions& options, CommandRun& command_run, ExitCode& exit_code) {
  const LoadOptions loading{options.read, command_run.run_options(), is_page(options),
                            command_run.progress().count("map after map")};
  const std::vector<std::string> names = names_of(options.inputs);
  AnyScene scene;
  for (std::size_t k = 0; k < options.inputs.size(); ++k) {
    LoadedMap loaded = load(options.inputs[k], loading, command_run.stop());
    command_run.check_interrupted();
    command_run.progress().close();
    for (const std::string& remark : loaded.remarks) say(options.inputs[k].string() + ": " + remark);
    if (loaded.exit_code != ExitCode::kDone) exit_code = loaded.exit_code;
    const auto add = [&]<int Dim>(PlottedMap<Dim>& plotted) {
      if (k == 0) scene = Scene<Dim>();
      auto* const same = std::get_if<Scene<Dim>>(&scene);
      if (!same) {
        fail(ErrorKind::kUsage, options.inputs[k].string() + ": is not of the same dimension as the maps before it");
      }
      plotted.name = names[k];
      const std::string capped = ellipse_cap(plotted.map).in_words();
      if (!capped.empty()) say(options.inputs[k].string() + ": " + capped);
      same->maps.push_back(std::move(plotted));
    };
    std::visit(add, loaded.plotted);
  }
  return scene;
}

/// Moves everything into the frame of the first map, and says what could not be aligned.
template <int Dim>
void align_all(const PlotOptions& options, Scene<Dim>& scene) {
  const PlottedMap<Dim>& first = scene.maps.front();
  const auto align = [&](auto& what, const Expected<Pose<Dim>>& frame, const std::filesystem::path& file) {
    if (frame) return move(*frame, what);
    say(file.string() + ": " + frame.error().message + "; it is drawn as it stands");
  };
  for (std::size_t k = 1; k < scene.maps.size(); ++k) align(scene.maps[k], alignment(scene.maps[k], first), options.inputs[k]);
  if (scene.truth) align(*scene.truth, alignment(*scene.truth, first.map), options.truth_of_first);
}

template <int Dim>
std::string drawn(const PlotOptions& options, const Scene<Dim>& scene) {
  if (!is_page(options)) return picture(map_layers(scene.maps, scene.truth ? &*scene.truth : nullptr));
  std::string title = scene.maps.front().name;
  for (std::size_t k = 1; k < scene.maps.size(); ++k) title += ", " + scene.maps[k].name;
  return viewer_page(scene, title);
}

/// Reads the truth of the first map, and says of how few poses it is if not of all; fails if it is of nothing in it.
template <int Dim>
Truth<Dim> read_truth(const PlotOptions& options, const GlobalMap<Dim>& first) {
  TruthFile file(options.truth_of_first, kMatchingTimes, options.read);
  file.take_map(options.inputs.front());
  if (file.leaves_features_out()) {
    say(options.truth_of_first.string() + ": its features are not drawn: --associate named them, or those of the first map");
  }
  const Truth<Dim> truth = file.of(first);
  const auto is_known = [](const auto& value) { return value.has_value(); };
  const auto known = std::ranges::count_if(truth.poses, is_known);
  if (known == 0 && std::ranges::none_of(truth.features, is_known)) {
    fail(ErrorKind::kUsage, fmt::format("{}: has no pose or feature of {}, by name, time or count; leave --truth out",
                                        options.truth_of_first.string(), options.inputs.front().string()));
  }
  if (known < std::ssize(truth.poses)) {
    say(fmt::format("{}: has {} of the {} of the first map, and is drawn at no others", options.truth_of_first.string(), known,
                    plural(truth.poses.size(), "pose")));
  }
  return truth;
}

template <int Dim>
std::string plot_scene(const PlotOptions& options, Scene<Dim>& scene) {
  if (!options.truth_of_first.empty()) scene.truth = read_truth(options, scene.maps.front().map);
  if (options.align) align_all(options, scene);
  demand(write_file(options.output, drawn(options, scene)));
  Lines lines;
  for (const auto& plotted : scene.maps) {
    lines.add("map", fmt::format("{}: {}D, {}, {}, {}{}", plotted.name, Dim, plural(plotted.map.poses.size(), "pose"),
                                 plural(plotted.map.features.size(), "feature"), plural(plotted.local_maps.size(), "local map"),
                                 plotted.is_odometry ? ", from odometry alone" : ""));
  }
  lines.add("written", options.output.string());
  return lines.text();
}

ExitCode plot(const PlotOptions& options, const std::stop_token& stop) {
  CommandRun command_run("plot", options, stop);
  command_run.prepare(outputs_of(options));
  ExitCode exit_code = ExitCode::kDone;
  AnyScene scene = load_all(options, command_run, exit_code);
  command_run.tell("", std::visit([&](auto& of_dim) { return plot_scene(options, of_dim); }, scene));
  return exit_code;
}

std::vector<std::string> check_files(const PlotOptions& options) {
  NamedFiles inputs = {{"--truth", options.truth_of_first}};
  for (const auto& input : options.inputs) inputs.emplace_back("MAP", input);
  return output_conflicts(inputs, outputs_of(options));
}

/// A violation, in words: an output that by its extension is neither a picture nor a page; one without is a picture.
std::vector<std::string> check_picture(const PlotOptions& options) {
  if (!goes_by_extension(options.output) || extension_of(options.output) == ".svg" || is_page(options)) return {};
  return {fmt::format("--output: {} has neither the extension of a picture, .svg, nor that of a page, .html",
                      options.output.string())};
}

}  // namespace

void declare_plot(Subcommand& command) {
  command.examples(
      "  mapjoin run data/manhattan2d.g2o -o result --covariances\n"
      "  mapjoin plot result -o map.svg --truth data/manhattan2d.truth.tum\n"
      "  mapjoin plot result data/manhattan2d.g2o -o map-and-odometry.svg\n"
      "  mapjoin build data/manhattan3d.g2o -o manhattan3d.maps\n"
      "  mapjoin plot manhattan3d.maps --covariances -o manhattan3d.html");
  const auto options = std::make_shared<PlotOptions>();
  options->output = "plot.svg";
  command.arguments("MAP", options->inputs,
                    "The folder of a run, a map or a log (without values by its odometry), or local maps, which are joined "
                    "first; several are overlaid");
  command.path("-o,--output", options->output, "FILE",
               "Write a picture (.svg), or a page to look around in (.html) [plot.svg]");
  command.path("--truth", options->truth_of_first, "FILE", "Draw the truth of the first map, too: " + kTruthFiles);
  command.refusal("--no-align", options->align, "Overlay maps as they stand, not by what they share with the first one");
  command.flag("--covariances", options->covariances,
               "Local maps: with their covariances when joined; those of a map are drawn where they are beside it");
  command.group("Reading");
  command.flag("--repair-information", options->read.repair_information,
               "Take the nearest semidefinite matrix for an indefinite information matrix");
  add_leniency(command, *options, ", also of the truth");
  add_running(command, *options);
  command.check([options] { return check_picture(*options); });
  command.check([options] { return check_files(*options); });
  command.act([options](const std::stop_token& stop) { return plot(*options, stop); });
}

}  // namespace mapjoin::apps
