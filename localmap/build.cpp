// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/localmap/segment_problem.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mutex>
#include <utility>

namespace mapjoin {

template <int Dim>
BuiltMap<Dim> build_local_map(const SegmentView<Dim>& view, const MinimiseOptions& solver, const std::stop_token& stop) {
  SegmentFreedom freedom;
  freedom.features.assign(view.features.size(), true);
  SegmentProblem<Dim> problem(view, freedom, composed_start(view));
  const MinimiseResult result = minimise(problem, solver, stop);
  BuiltMap<Dim> built;
  built.iterations = result.iterations;
  const bool is_usable = result.status == MinimiseStatus::kConverged || result.status == MinimiseStatus::kMaxIterations;
  if (!is_usable) return built;
  auto information = problem.marginal_information();
  if (!information) return built;

  LocalMap<Dim>& map = built.map.emplace();
  map.base = view.begin;
  map.poses = view.kept;
  map.features = view.features;
  for (const PoseIndex pose : view.kept) {
    map.pose_estimates.push_back(problem.estimate().poses[view.place(pose)]);
  }
  map.feature_estimates = problem.estimate().features;
  map.information = std::move(*information);
  map.chi2 = result.chi2;
  return built;
}

template <int Dim>
Expected<LocalMaps<Dim>> build_local_maps(const Log<Dim>& log, Split& split, const BuildOptions& options,
                                          const std::stop_token& stop) {
  demand_valid(options.solver);
  if (const auto checked = check_split(log, split); !checked) return tl::unexpected(checked.error());
  const auto to_do = static_cast<std::size_t>(
      std::count_if(split.segments.begin(), split.segments.end(), [](const Segment& s) { return s.is_map; }));
  std::vector<BuiltMap<Dim>> built(split.segments.size());
  std::mutex progress_mutex;
  std::size_t done = 0;
  parallel_for(built.size(), [&](std::size_t k) {
    if (!split.segments[k].is_map || stop.stop_requested()) return;
    built[k] = build_local_map(segment_view(log, split, split.segments[k]), options.solver, stop);
    if (!options.progress) return;
    const std::lock_guard lock(progress_mutex);
    options.progress(++done, to_do);
  });
  if (stop.stop_requested()) return interrupted("building local maps");

  LocalMaps<Dim> result;
  for (std::size_t k = 0; k < built.size(); ++k) {
    if (!split.segments[k].is_map) continue;
    result.iterations += built[k].iterations;
    if (built[k].map) {
      result.maps.push_back(std::move(*built[k].map));
    } else {
      make_raw(split.segments[k], split);
    }
  }
  return result;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                   \
  template BuiltMap<Dim> build_local_map(const SegmentView<Dim>&, const MinimiseOptions&, const std::stop_token&); \
  template Expected<LocalMaps<Dim>> build_local_maps(const Log<Dim>&, Split&, const BuildOptions&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
