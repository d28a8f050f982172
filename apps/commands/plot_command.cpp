// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin plot`: pictures of maps, logs and local maps.

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <apps/commands/commands.hpp>
#include <apps/console.hpp>
#include <apps/map_file.hpp>
#include <apps/output_conflicts.hpp>
#include <apps/picture/load.hpp>
#include <apps/picture/picture.hpp>
#include <apps/picture/plotted_map.hpp>
#include <apps/picture/viewer_page.hpp>
#include <apps/progress.hpp>
#include <apps/truth_file.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

namespace mapjoin::apps {
namespace {

constexpr const char* kExamples =
    "  mapjoin run data/manhattan2d.g2o -o result --covariances\n"
    "  mapjoin plot result -o map.svg --truth data/manhattan2d.truth.tum\n"
    "  mapjoin plot result data/manhattan2d.g2o -o map-and-odometry.svg\n"
    "  mapjoin build data/manhattan3d.g2o -o manhattan3d.maps\n"
    "  mapjoin plot manhattan3d.maps --covariances -o manhattan3d.html";

struct PlotOptions {
  std::vector<std::filesystem::path> inputs;
  Options common;
  bool align = true;
};

bool is_page(const PlotOptions& options) {
  return options.common.output.extension() == ".html";
}

/// Names that tell the maps apart: those of their files, with their folders where these are the same.
std::vector<std::string> names_of(const std::vector<std::filesystem::path>& paths) {
  std::vector<std::string> files;
  for (const auto& path : paths) files.push_back((path.has_filename() ? path : path.parent_path()).filename().string());
  std::vector<std::string> names;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    names.push_back(std::count(files.begin(), files.end(), files[k]) > 1 ? paths[k].string() : files[k]);
  }
  return names;
}

/// Says what is wrong with a joined map, and gives its exit code.
Expected<AnyScene> load_all(const PlotOptions& options, const LoadOptions& loading, const std::stop_token& stop,
                            ExitCode& exit_code) {
  std::optional<AnyScene> scene;
  const std::vector<std::string> names = names_of(options.inputs);
  for (std::size_t k = 0; k < options.inputs.size(); ++k) {
    auto loaded = load(options.inputs[k], loading, stop);
    if (!loaded) return tl::unexpected(loaded.error());
    if (stop.stop_requested()) return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted"});
    const bool is_taken = std::visit(
        [&]<int Dim>(PlottedMap<Dim>& plotted) {
          if (!scene) scene = Scene<Dim>();
          auto* same = std::get_if<Scene<Dim>>(&*scene);
          if (!same) return false;
          plotted.name = names[k];
          same->maps.push_back(std::move(plotted));
          return true;
        },
        loaded->plotted);
    for (const std::string& remark : loaded->remarks) say(options.inputs[k].string() + ": " + remark);
    if (loaded->exit_code != ExitCode::kDone) exit_code = loaded->exit_code;
    if (is_taken) continue;
    return tl::unexpected(Error{ErrorKind::kUsage, fmt::format("{}: is not of the same dimension as {}",
                                                               options.inputs[k].string(), options.inputs.front().string())});
  }
  return *std::move(scene);
}

template <int Dim>
Expected<void> read_truth(const std::filesystem::path& path, Scene<Dim>& scene) {
  if (path.empty()) return {};
  const auto file = TruthFile::open(path);
  if (!file) return tl::unexpected(file.error());
  return file->of(scene.maps.front().map).map([&](Truth<Dim>&& truth) { scene.truth = std::move(truth); });
}

/// Puts everything into the frame of the first map, and says what could not be.
template <int Dim>
void align_all(const PlotOptions& options, Scene<Dim>& scene) {
  if (!options.align) return;
  const GlobalMap<Dim>& first = scene.maps.front().map;
  const auto stays = [](const std::string& what) {
    say(what + ": shares too little with the first map to be aligned with it, and is drawn as it stands");
  };
  for (std::size_t k = 1; k < scene.maps.size(); ++k) {
    if (const auto frame = alignment(scene.maps[k].map, first)) {
      move(*frame, scene.maps[k]);
    } else {
      stays(options.inputs[k].string());
    }
  }
  if (!scene.truth) return;
  if (const auto frame = alignment(*scene.truth, first)) {
    move(*frame, *scene.truth);
  } else {
    stays(options.common.truth.string());
  }
}

template <int Dim>
std::string title_of(const Scene<Dim>& scene) {
  std::string title = scene.maps.front().name;
  for (std::size_t k = 1; k < scene.maps.size(); ++k) title += ", " + scene.maps[k].name;
  return title;
}

template <int Dim>
Expected<void> plot_scene(const PlotOptions& options, Scene<Dim>& scene) {
  if (auto read = read_truth(options.common.truth, scene); !read) return tl::unexpected(read.error());
  align_all(options, scene);
  const std::string drawn = is_page(options) ? viewer_page(scene, title_of(scene))
                                             : picture(map_layers(scene.maps, scene.truth ? &*scene.truth : nullptr));
  if (auto written = write_file(options.common.output, drawn); !written) return tl::unexpected(written.error());
  if (options.common.quiet) return {};
  Lines lines;
  for (const auto& plotted : scene.maps) {
    lines.add("map", fmt::format("{}: {}D, {} poses, {} features, {} local maps{}", plotted.name, Dim, plotted.map.poses.size(),
                                 plotted.map.features.size(), plotted.local_maps.size(),
                                 plotted.is_odometry ? ", from odometry alone" : ""));
  }
  lines.add("written", options.common.output.string());
  return write_stdout(lines.text());
}

Expected<ExitCode> plot(const PlotOptions& options, const std::stop_token& stop) {
  if (auto ready = check_writable(options.common.output); !ready) return tl::unexpected(ready.error());
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, thread_count(options.common));
  Progress progress(!options.common.quiet);
  LoadOptions loading;
  loading.read = options.common.read;
  loading.run.marginals = options.common.covariances;
  loading.run.progress = progress.callback();
  loading.has_stops = is_page(options);
  if (const auto show = progress.callback_in_words()) {
    loading.progress = [show](std::size_t done, std::size_t to_do) { show("map after map", done, to_do); };
  }
  ExitCode exit_code = ExitCode::kDone;
  auto scene = load_all(options, loading, stop, exit_code);
  progress.close();
  if (!scene) return tl::unexpected(scene.error());
  return std::visit([&](auto& of_dim) { return plot_scene(options, of_dim); }, *scene).map([&] { return exit_code; });
}

std::vector<std::string> check_files(const PlotOptions& options) {
  NamedFiles files = {{"--output", options.common.output}};
  std::vector<std::string> violations;
  for (const auto& input : options.inputs) {
    files.resize(1);
    files.emplace_back("MAP", input);
    for (auto& violation : output_conflicts(files)) violations.push_back(std::move(violation));
  }
  files.resize(1);
  files.emplace_back("--truth", options.common.truth);
  for (auto& violation : output_conflicts(files)) violations.push_back(std::move(violation));
  return violations;
}

void declare(Subcommand& command) {
  const auto options = std::make_shared<PlotOptions>();
  Options& common = options->common;
  common.output = "plot.svg";
  command.arguments("MAP", options->inputs,
                    "The folder of a run, a map or a log (without values by its odometry), or local maps, which are joined "
                    "first; several are overlaid");
  command.path("-o,--output", common.output, "FILE",
               "Write a picture as SVG or, where the name ends in .html, a page to look around in [plot.svg]");
  command.path("--truth", common.truth, "FILE", "Draw the truth of the first map, too: .tum, else g2o with vertices");
  command.refusal("--no-align", options->align, "Overlay maps as they stand, not by what they share with the first one");
  command.flag("--covariances", common.covariances,
               "Local maps: with their covariances when joined; those of a map are drawn where they are beside it");
  command.flag("--repair-information", common.read.repair_information,
               "Take the nearest semidefinite matrix for an indefinite information matrix");
  add_running(command, common);
  command.check([options] { return check_files(*options); });
  command.act([options](const std::stop_token& stop) { return plot(*options, stop); });
}

}  // namespace

std::unique_ptr<Subcommand> plot_command(CLI::App& app) {
  return std::make_unique<Subcommand>(app, "plot", "Pictures of maps, logs and local maps, and pages to look around in",
                                      kExamples, declare);
}

}  // namespace mapjoin::apps
