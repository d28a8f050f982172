// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/align/leaf.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mutex>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
using Closures = std::vector<const PoseFactor<Dim>*>;

/// The number of times that partial maps are settled: once per join and, unless segments are joined one by one, once per leaf.
std::size_t joins(std::size_t segments, const JoinRule& rule, std::size_t at_once) {
  if (!rule.is_map_by_map()) return 2 * segments - 1;
  return at_once == 1 ? segments : 2 * segments;
}

/// The number of segments on the left branch of a tree over at least two; a lot of a map-by-map schedule is joined along a
/// balanced tree.
std::size_t left_branch(std::size_t segments, const JoinRule& rule) {
  const double share = rule.is_map_by_map() ? 0.5 : rule.left_share;
  return std::max<std::size_t>(1, static_cast<std::size_t>(share * static_cast<double>(segments)));
}

template <int Dim>
class Joiner {
 public:
  Joiner(const SubmapGraph<Dim>& graph, const ScheduleOptions& options, const std::stop_token& stop, std::size_t at_once = 1)
      : graph_(graph),
        options_(options),
        stop_(stop),
        at_once_(at_once),
        leaves_(graph),
        rule_(rule_of(options.schedule)),
        solver_(solver_of(rule_.solve)),
        to_do_(joins(graph.segments.size(), rule_, at_once)) {}

  JoinedPartialMaps<Dim> all() {
    if (rule_.is_map_by_map()) return one_after_another(nullptr);
    return range(0, graph_.segments.size(), leaves_.closures());
  }

  /// Joins segments one by one, or in lots of `at_once_`, each of which is joined first.
  JoinedPartialMaps<Dim> one_after_another(const JoinWatch<Dim>& watch) {
    const std::size_t count = graph_.segments.size();
    std::vector<Closures<Dim>> within((count + at_once_ - 1) / at_once_);
    std::vector<Closures<Dim>> closed_by(within.size());
    for (const auto* closure : leaves_.closures()) {
      const auto [first, last] = leaves_.segments_of(*closure);
      const bool is_within = at_once_ > 1 && first / at_once_ == last / at_once_;
      (is_within ? within : closed_by)[last / at_once_].push_back(closure);
    }
    JoinedPartialMaps<Dim> so_far;
    for (std::size_t lot = 0; lot < within.size(); ++lot) {
      const std::size_t low = lot * at_once_;
      const std::size_t high = std::min(low + at_once_, count);
      JoinedPartialMaps<Dim> next =
          at_once_ == 1 ? JoinedPartialMaps<Dim>{{leaves_.partial(low)}, {}} : range(low, high, std::move(within[lot]));
      so_far = joined(std::move(so_far), std::move(next), std::move(closed_by[lot]));
      if (watch && !stop_.stop_requested()) watch(high, so_far);
    }
    return so_far;
  }

 private:
  /// The join of segments [low, high) and of the closures among them.
  JoinedPartialMaps<Dim> range(std::size_t low, std::size_t high, Closures<Dim> closures) {
    if (high - low == 1) return settled({leaves_.partial(low)}, std::move(closures));
    const std::size_t middle = low + left_branch(high - low, rule_);
    Closures<Dim> left, right, here;
    for (const auto* closure : closures) {
      const auto [first, last] = leaves_.segments_of(*closure);
      (last < middle ? left : first >= middle ? right : here).push_back(closure);
    }
    JoinedPartialMaps<Dim> a, b;
    parallel_invoke([&] { a = range(low, middle, std::move(left)); }, [&] { b = range(middle, high, std::move(right)); });
    return joined(std::move(a), std::move(b), std::move(here));
  }

  JoinedPartialMaps<Dim> joined(JoinedPartialMaps<Dim> a, JoinedPartialMaps<Dim> b, Closures<Dim> here) {
    for (auto* pending : {&a.pending, &b.pending}) here.insert(here.end(), pending->begin(), pending->end());
    std::vector<PartialMap<Dim>> partials = std::move(a.partials);
    std::move(b.partials.begin(), b.partials.end(), std::back_inserter(partials));
    if (stop_.stop_requested()) return {std::move(partials), std::move(here)};
    partials = merge_tied(std::move(partials), here, rule_.tries_hypotheses);
    return settled(std::move(partials), std::move(here));
  }

  /// Gives each closure to the partial map that holds both its poses, and leads every partial map towards its optimum.
  JoinedPartialMaps<Dim> settled(std::vector<PartialMap<Dim>> partials, Closures<Dim> closures) {
    JoinedPartialMaps<Dim> result;
    for (const auto* closure : closures) {
      const auto owner = std::find_if(partials.begin(), partials.end(), [&](const PartialMap<Dim>& partial) {
        return holds(partial.poses, closure->base) && holds(partial.poses, closure->target);
      });
      if (owner == partials.end()) {
        result.pending.push_back(closure);
      } else {
        owner->factors.pose_factors.push_back(closure);
      }
    }
    const bool is_last = !partials.empty() && partials.front().poses.size() == leaves_.joined_pose_count();
    const bool is_solved = rule_.solve != SolveOnTheWay::kNone && !is_last;
    for (auto& partial : partials) {
      if (is_solved && !stop_.stop_requested()) lead(partial);
    }
    result.partials = std::move(partials);
    report_progress();
    return result;
  }

  void lead(PartialMap<Dim>& partial) {
    const auto& [pose_factors, feature_factors, submaps] = partial.factors;
    if (submaps.size() == 1 && pose_factors.empty() && feature_factors.empty()) return;
    JoiningSystem<Dim> join(partial, {{0}, {}});
    minimise_join(join, options_.state, solver_, stop_);
    partial.state = join.estimate();
  }

  void report_progress() {
    if (!options_.progress) return;
    const std::lock_guard lock(progress_mutex_);
    options_.progress(++done_, to_do_);
  }

  const SubmapGraph<Dim>& graph_;
  const ScheduleOptions& options_;
  const std::stop_token& stop_;
  std::size_t at_once_;
  Leaves<Dim> leaves_;
  const JoinRule& rule_;
  MinimiseOptions solver_;  // of the joins on the way
  std::mutex progress_mutex_;
  std::size_t done_ = 0;
  std::size_t to_do_;
};

}  // namespace

MinimiseOptions solver_of(SolveOnTheWay solve) {
  const bool by_threshold = solve == SolveOnTheWay::kByThreshold;
  MinimiseOptions options;
  options.max_iterations = 50;
  options.relative_chi2 = 1e-4;
  options.step_metres = by_threshold ? 0.1 : 1e-3;
  options.step_radians = by_threshold ? 1e-2 : 1e-4;
  options.damp_singular = true;
  return options;
}

template <int Dim>
JoinedPartialMaps<Dim> join_segments(const SubmapGraph<Dim>& graph, const ScheduleOptions& options,
                                     const std::stop_token& stop) {
  return Joiner<Dim>(graph, options, stop).all();
}

template <int Dim>
void watch_join(const SubmapGraph<Dim>& graph, std::size_t at_once, const JoinWatch<Dim>& watch,
                const std::function<void(std::size_t, std::size_t)>& progress, const std::stop_token& stop) {
  const ScheduleOptions options{Schedule::kSequential, JoinedState::kAbsolute, progress};
  Joiner<Dim>(graph, options, stop, at_once).one_after_another(watch);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                          \
  template JoinedPartialMaps<Dim> join_segments(const SubmapGraph<Dim>&, const ScheduleOptions&, const std::stop_token&); \
  template void watch_join(const SubmapGraph<Dim>&, std::size_t, const JoinWatch<Dim>&,                                   \
                           const std::function<void(std::size_t, std::size_t)>&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
