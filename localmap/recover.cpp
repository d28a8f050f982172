// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <mapjoin/localmap/recover.hpp>
#include <mapjoin/localmap/segment_problem.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Composes interior poses by odometry from the kept pose before them; kept poses stay as they are.
template <int Dim>
void compose_interior(const SegmentView<Dim>& view, Values<Dim>& values) {
  const Values<Dim> composed = composed_start(view);
  auto next_kept = view.kept.begin();
  PoseIndex anchor = view.begin;
  for (PoseIndex pose = view.begin + 1; pose <= view.end; ++pose) {
    if (pose == *next_kept) {
      anchor = pose;
      ++next_kept;
      continue;
    }
    const PoseIndex p = view.place(pose);
    const PoseIndex a = view.place(anchor);
    values.poses[p] = compose(values.poses[a], between(composed.poses[a], composed.poses[p]));
  }
}

/// Recovers the interior of one segment; true if its solve converged.
template <int Dim>
bool recover_interior(const SegmentView<Dim>& view, const Table<FeatureIndex, bool>& is_local, const MinimiseOptions& solver,
                      const std::stop_token& stop, Values<Dim>& state) {
  SegmentFreedom freedom;
  freedom.kept = false;
  for (const FeatureIndex feature : view.features) freedom.features.push_back(is_local[feature]);
  Values<Dim> start = values_of(view, state);
  compose_interior(view, start);
  SegmentProblem<Dim> problem(view, freedom, std::move(start));
  const MinimiseResult result = minimise(problem, solver, stop);
  for (const PoseIndex pose : view.interior) {
    state.poses[pose] = problem.estimate().poses[view.place(pose)];
  }
  for (const FeatureIndex f : indices(view.features)) {
    if (freedom.features[f]) state.features[view.features[f]] = problem.estimate().features[f];
  }
  return result.status == MinimiseStatus::kConverged;
}

}  // namespace

template <int Dim>
Values<Dim> values_of(const SegmentView<Dim>& view, const Values<Dim>& state) {
  Values<Dim> values;
  values.poses.assign(state.poses.begin() + view.begin.value, state.poses.begin() + view.end.value + 1);
  for (const FeatureIndex feature : view.features) values.features.push_back(state.features[feature]);
  return values;
}

template <int Dim>
std::size_t recover_interiors(const Log<Dim>& log, const Split& split, const Table<FeatureIndex, bool>& is_local,
                              const MinimiseOptions& solver, Values<Dim>& state, const std::stop_token& stop) {
  std::atomic<std::size_t> failed = 0;
  parallel_for(split.segments.size(), [&](std::size_t k) {
    if (!split.segments[k].is_map) return;
    if (!recover_interior(segment_view(log, split, split.segments[k]), is_local, solver, stop, state)) ++failed;
  });
  return failed;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                          \
  template Values<Dim> values_of(const SegmentView<Dim>&, const Values<Dim>&);                            \
  template std::size_t recover_interiors(const Log<Dim>&, const Split&, const Table<FeatureIndex, bool>&, \
                                         const MinimiseOptions&, Values<Dim>&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
