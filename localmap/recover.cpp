// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <mapjoin/localmap/recover.hpp>
#include <mapjoin/localmap/segment_problem.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Interior poses from odometry after the pose before them; what is kept stays as it is.
template <int Dim>
void compose_interior(const SegmentView<Dim>& view, Values<Dim>& values) {
  const Values<Dim> composed = composed_start(view);
  auto next_kept = view.kept.begin();
  Index anchor = view.begin;
  for (Index pose = view.begin + 1; pose <= view.end; ++pose) {
    if (pose == *next_kept) {
      anchor = pose;
      ++next_kept;
      continue;
    }
    const auto p = static_cast<std::size_t>(pose - view.begin);
    const auto a = static_cast<std::size_t>(anchor - view.begin);
    values.poses[p] = compose(values.poses[a], between(composed.poses[a], composed.poses[p]));
  }
}

/// Returns whether the segment's own solve converged.
template <int Dim>
bool recover_interior(const SegmentView<Dim>& view, const std::vector<bool>& is_local, const MinimiseOptions& solver,
                      const std::stop_token& stop, Values<Dim>& state) {
  SegmentFreedom freedom;
  freedom.kept = false;
  for (const Index feature : view.features) freedom.features.push_back(is_local[static_cast<std::size_t>(feature)]);
  Values<Dim> start = values_of(view, state);
  compose_interior(view, start);
  SegmentProblem<Dim> problem(view, freedom, std::move(start));
  const MinimiseResult result = minimise(problem, solver, stop);
  for (const Index pose : view.interior) {
    state.poses[static_cast<std::size_t>(pose)] = problem.estimate().poses[static_cast<std::size_t>(pose - view.begin)];
  }
  for (std::size_t f = 0; f < view.features.size(); ++f) {
    if (freedom.features[f]) state.features[static_cast<std::size_t>(view.features[f])] = problem.estimate().features[f];
  }
  return result.status == MinimiseStatus::kConverged;
}

}  // namespace

template <int Dim>
Values<Dim> values_of(const SegmentView<Dim>& view, const Values<Dim>& state) {
  Values<Dim> values;
  values.poses.assign(state.poses.begin() + view.begin, state.poses.begin() + view.end + 1);
  for (const Index feature : view.features) values.features.push_back(state.feature(feature));
  return values;
}

template <int Dim>
std::size_t recover_interiors(const Log<Dim>& log, const Split& split, const std::vector<bool>& is_local,
                              const MinimiseOptions& solver, Values<Dim>& state, const std::stop_token& stop) {
  std::atomic<std::size_t> failed = 0;
  parallel_for(split.segments.size(), [&](std::size_t k) {
    if (!split.segments[k].is_map) return;
    if (!recover_interior(segment_view(log, split, split.segments[k]), is_local, solver, stop, state)) ++failed;
  });
  return failed;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                          \
  template Values<Dim> values_of(const SegmentView<Dim>&, const Values<Dim>&);                                            \
  template std::size_t recover_interiors(const Log<Dim>&, const Split&, const std::vector<bool>&, const MinimiseOptions&, \
                                         Values<Dim>&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
