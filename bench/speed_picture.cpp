// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/chart.hpp>
#include <array>

#include "speed_result.hpp"

namespace mapjoin::bench {
namespace {

struct Style {
  const char* program;
  std::size_t colour;
  apps::Line line;
};
constexpr std::array kStyles = {Style{"run", 0, apps::Line::kSolid},
                                Style{"run --jobs 2", 0, apps::Line::kDashed},
                                Style{"solve", 1, apps::Line::kSolid},
                                Style{"ceres cholesky lm", 2, apps::Line::kSolid},
                                Style{"ceres cholesky dogleg", 2, apps::Line::kDashed},
                                Style{"ceres schur lm", 3, apps::Line::kSolid},
                                Style{"ceres schur dogleg", 3, apps::Line::kDashed},
                                Style{"limit", 6, apps::Line::kSolid}};

enum class Of : std::uint8_t { kWorlds, kRealSets };

/// A figure of one program over the number of poses; those that did not get anywhere are left out.
apps::Curve curve_of(const std::vector<Result>& results, const Style& style, Figure figure, Of of) {
  apps::Curve curve{"", {}, of == Of::kWorlds ? style.line : apps::Line::kNone, true, style.colour};
  for (const Result& result : results) {
    if (result.data.is_maps || result.data.is_simulated != (of == Of::kWorlds)) continue;
    for (const Runs& runs : result.runs) {
      if (runs.program.name != style.program || !runs.trials.front().chi2) continue;
      curve.points.push_back({static_cast<double>(pose_count(result)), median_of(runs, figure)});
    }
  }
  std::sort(curve.points.begin(), curve.points.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
  return curve;
}

apps::Chart chart_of(const std::vector<Result>& results, Figure figure, const char* title, const char* unit) {
  apps::Chart chart{title, {"poses", true}, {unit, true}, {}, 560.0, 420.0};
  for (const Style& style : kStyles) {
    for (const Of of : {Of::kWorlds, Of::kRealSets}) chart.curves.push_back(curve_of(results, style, figure, of));
  }
  return chart;
}

/// Names the curves of the worlds; those of other sets have their colours.
void name(apps::Chart& chart) {
  for (std::size_t s = 0; s < kStyles.size(); ++s) {
    if (!chart.curves[2 * s].points.empty()) chart.curves[2 * s].name = kStyles[s].program;
  }
}

}  // namespace

std::string picture_of(const std::vector<Result>& results) {
  std::vector<apps::Chart> charts = {chart_of(results, &Trial::cpu_seconds, "Time", "CPU (s)"),
                                     chart_of(results, &Trial::memory_mb, "Memory", "largest resident memory (MB)")};
  name(charts.front());
  return apps::svg(charts, charts.size());
}

}  // namespace mapjoin::bench
