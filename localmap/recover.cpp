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
void compose_interior(const Segment<Dim>& segment, State<Dim>& values) {
  const State<Dim> composed = composed_start(segment);
  auto next_kept = segment.kept.begin();
  Index anchor = segment.begin;
  for (Index pose = segment.begin + 1; pose <= segment.end; ++pose) {
    if (pose == *next_kept) {
      anchor = pose;
      ++next_kept;
      continue;
    }
    const auto p = static_cast<std::size_t>(pose - segment.begin);
    const auto a = static_cast<std::size_t>(anchor - segment.begin);
    values.poses[p] = compose(values.poses[a], between(composed.poses[a], composed.poses[p]));
  }
}

/// Returns whether the segment's own solve converged.
template <int Dim>
bool recover_interior(const Segment<Dim>& segment, const std::vector<bool>& is_private, const MinimiseOptions& solver,
                      const std::stop_token& stop, State<Dim>& state) {
  SegmentFreedom freedom;
  freedom.kept = false;
  for (const Index feature : segment.features) freedom.features.push_back(is_private[static_cast<std::size_t>(feature)]);
  State<Dim> start = values_of(segment, state);
  compose_interior(segment, start);
  SegmentProblem<Dim> problem(segment, freedom, std::move(start));
  const MinimiseResult result = minimise(problem, solver, stop);
  for (const Index pose : segment.interior) {
    state.poses[static_cast<std::size_t>(pose)] = problem.estimate().poses[static_cast<std::size_t>(pose - segment.begin)];
  }
  for (std::size_t f = 0; f < segment.features.size(); ++f) {
    if (freedom.features[f]) state.features[static_cast<std::size_t>(segment.features[f])] = problem.estimate().features[f];
  }
  return result.status == MinimiseStatus::kConverged;
}

}  // namespace

template <int Dim>
State<Dim> values_of(const Segment<Dim>& segment, const State<Dim>& state) {
  State<Dim> values;
  values.poses.assign(state.poses.begin() + segment.begin, state.poses.begin() + segment.end + 1);
  for (const Index feature : segment.features) values.features.push_back(state.feature(feature));
  return values;
}

template <int Dim>
std::size_t recover_interiors(const Log<Dim>& log, const Split& split, const std::vector<bool>& is_private,
                              const MinimiseOptions& solver, State<Dim>& state, const std::stop_token& stop) {
  std::atomic<std::size_t> failed = 0;
  parallel_for(split.stretches.size(), [&](std::size_t k) {
    if (!split.stretches[k].is_map) return;
    if (!recover_interior(segment_of(log, split, split.stretches[k]), is_private, solver, stop, state)) ++failed;
  });
  return failed;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                          \
  template State<Dim> values_of(const Segment<Dim>&, const State<Dim>&);                                                  \
  template std::size_t recover_interiors(const Log<Dim>&, const Split&, const std::vector<bool>&, const MinimiseOptions&, \
                                         State<Dim>&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
