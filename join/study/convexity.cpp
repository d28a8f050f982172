// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/study/convexity.hpp>
#include <mapjoin/join/study/convexity_objective.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <mapjoin/solve/memory_limit.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// A pair of states of the whole submap graph.
template <int Dim>
struct Pair {
  Values<Dim> X;
  Values<Dim> Y;
};

/// The best estimate, by the default method: the reference for headings, and F*.
template <int Dim>
struct Best {
  Values<Dim> state;  // of the whole submap graph
  double chi2;
};

/// The composed start of the joined state of a submap graph, with the first pose at `origin` if neither priors nor fixed poses
/// place it.
template <int Dim>
PartialMap<Dim> composed_start(const SubmapGraph<Dim>& graph, const Pose<Dim>& origin) {
  PartialMap<Dim> joined_map = joined_map_of(graph);
  joined_map.state = composed_state(graph, joined_map, origin, join_segments(graph, {Schedule::kBatch, {}, {}}));
  place_fixed_poses(graph, joined_map);
  return joined_map;
}

/// One of the two least-squares problems, full SLAM or joining, ready to be evaluated.
template <int Dim>
class PosedProblem {
 public:
  PosedProblem(SubmapGraph<Dim> graph, const Best<Dim>& best, bool is_joining)
      : graph_(std::move(graph)),
        composed_(composed_start(graph_, best.state.poses.front())),
        join_(composed_, gauge_of(graph_, composed_)),
        best_(best),
        best_part_(restricted(best.state, composed_)),
        is_joining_(is_joining) {}
  PosedProblem(const PosedProblem&) = delete;
  PosedProblem& operator=(const PosedProblem&) = delete;

  /// The pairs of states that the options ask for, over the whole submap graph.
  std::vector<Pair<Dim>> drawn_pairs(const ConvexityOptions& options) {
    const StateSampler<Dim> sampler(options.source, options.spread, composed_, join_, best_part_);
    const auto state = [&](std::size_t number) {
      Values<Dim> all{Table<PoseIndex, Pose<Dim>>(graph_.pose_count),
                      Table<FeatureIndex, Point<Dim>>(graph_.feature_count, Point<Dim>::Zero())};
      const Values<Dim> drawn = sampler.draw(RandomStream(options.seed, number).next());
      write_values(drawn, composed_.poses, composed_.features, all);
      return all;
    };
    std::vector<Pair<Dim>> pairs;
    for (std::size_t k = 0; k < options.pairs; ++k) {
      pairs.push_back({state(2 * k), options.to_best ? best_.state : state(2 * k + 1)});
    }
    return pairs;
  }

  Expected<FormulationFigures> figures(JoinedState state, const std::vector<Pair<Dim>>& pairs, std::size_t points,
                                       const std::function<void()>& segment_done, const std::stop_token& stop) {
    FormulationFigures figures{{is_joining_, state}, graph_.maps.size(), {}, {}, {}, first_step(state)};
    join_.estimate() = best_part_;
    join_.linearise();
    if (join_.factorise(0.0)) return bad_input("the best estimate is not determined by the observations");
    const std::int64_t bytes = Marginals::bytes(join_.equations());
    if (auto fits = check_memory("the share of the information that is from linear rows", bytes, 0); !fits) {
      return tl::unexpected(fits.error());
    }
    figures.quadratic = quadratic_share(join_, state);
    const UnwrappedObjective<Dim> objective(join_, best_part_);
    const RelativeCoordinates<Dim> relative(join_, best_part_);
    for (const Pair<Dim>& pair : pairs) {
      if (stop.stop_requested()) return interrupted();
      const Values<Dim> X = restricted(pair.X, composed_);
      const Values<Dim> Y = restricted(pair.Y, composed_);
      LineOfStates line;
      if (state == JoinedState::kAbsolute) {
        line.values = sampled([&](double lambda) { return objective(on_line(X, Y, lambda)); }, points);
      } else {
        const Eigen::VectorXd x = relative.of(X);
        const Eigen::VectorXd y = relative.of(Y);
        line.values =
            sampled([&](double lambda) { return objective(relative.composed(lambda * x + (1.0 - lambda) * y)); }, points);
      }
      line.curvature = curvature_figures(line.values);
      figures.curvature.add(line.curvature);
      figures.segments.push_back(std::move(line));
      segment_done();
    }
    return figures;
  }

 private:
  FirstStep first_step(JoinedState state) {
    join_.estimate() = composed_.state;
    MinimiseOptions one_step;
    one_step.method = Method::kGaussNewton;
    one_step.max_iterations = 1;
    one_step.relative_chi2 = one_step.step_metres = one_step.step_radians = 0.0;
    const MinimiseResult result = minimise_join(join_, state, one_step);
    FirstStep step;
    step.start_chi2 = result.start_chi2;
    if (result.iterations > 0) step.chi2 = result.chi2;
    step.best_chi2 = best_.chi2;
    return step;
  }

  SubmapGraph<Dim> graph_;
  PartialMap<Dim> composed_;
  JoiningSystem<Dim> join_;
  Best<Dim> best_;
  Values<Dim> best_part_;  // of the joined state alone
  bool is_joining_;
};

/// The figures of all problems in both states, with pairs of states drawn from the first.
template <int Dim>
Expected<Convexity> figures_of(const std::vector<std::unique_ptr<PosedProblem<Dim>>>& problems, const ConvexityOptions& options,
                               const std::stop_token& stop) {
  const std::vector<Pair<Dim>> pairs = problems.front()->drawn_pairs(options);
  const std::size_t to_do = 2 * problems.size() * pairs.size();
  std::size_t done = 0;
  Convexity all;
  for (const auto& problem : problems) {
    for (const JoinedState state : {JoinedState::kAbsolute, JoinedState::kRelative}) {
      const auto segment_done = [&] {
        if (options.progress) options.progress(++done, to_do);
      };
      auto figures = problem->figures(state, pairs, options.points, segment_done, stop);
      if (!figures) return tl::unexpected(figures.error());
      all.push_back(std::move(*figures));
    }
  }
  return all;
}

}  // namespace

std::vector<std::string> ConvexityOptions::validate() const {
  std::vector<std::string> violations = split.validate();
  if (pairs < 1) violations.emplace_back("there must be a pair of states");
  if (points < 3) violations.emplace_back("a segment has an inner point from three points on");
  if (!(spread > 0.0 && std::isfinite(spread))) violations.emplace_back("the spread must be a positive number");
  return violations;
}

std::optional<double> FirstStep::share() const {
  const double whole = start_chi2 - best_chi2;
  if (!(whole > 1e-9 * start_chi2) || !std::isfinite(chi2)) return std::nullopt;
  return (start_chi2 - chi2) / whole;
}

template <int Dim>
Expected<Convexity> convexity(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps,
                              const ConvexityOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  if (has_levers(log.graph)) return bad_input_of(log.source, "the convexity of priors with levers is not looked at");
  const auto best = run_from_maps(log, split, maps, without_verdict(), stop);
  if (!best) return tl::unexpected(best.error());
  const Values<Dim> state{best->map.poses, best->map.features};
  const Split one_step = mapjoin::split(log, {SplitRule::kPoses, 1.0});
  std::vector<std::unique_ptr<PosedProblem<Dim>>> problems;
  problems.push_back(
      std::make_unique<PosedProblem<Dim>>(submap_graph_of(log, one_step, {}), Best<Dim>{state, best->chi2}, false));
  problems.push_back(
      std::make_unique<PosedProblem<Dim>>(submap_graph_of(log, split, maps), Best<Dim>{state, best->join.chi2}, true));
  return figures_of(problems, options, stop);
}

template <int Dim>
Expected<Convexity> convexity(const Log<Dim>& log, const ConvexityOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  if (auto connected = check_connected(log); !connected) return tl::unexpected(connected.error());
  Split parts = split(log, options.split);
  const auto built = build_local_maps(log, parts, {}, stop);
  if (!built) return tl::unexpected(built.error());
  return convexity(log, parts, built->maps, options, stop);
}

template <int Dim>
Expected<Convexity> convexity(const SubmapSet<Dim>& set, const ConvexityOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  const auto best = run(set, without_verdict(), stop);
  if (!best) return tl::unexpected(best.error());
  std::vector<std::unique_ptr<PosedProblem<Dim>>> problems;
  problems.push_back(std::make_unique<PosedProblem<Dim>>(submap_graph_of(set),
                                                         Best<Dim>{{best->map.poses, best->map.features}, best->chi2}, true));
  return figures_of(problems, options, stop);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                            \
  template Expected<Convexity> convexity(const Log<Dim>&, const ConvexityOptions&, const std::stop_token&); \
  template Expected<Convexity> convexity(const Log<Dim>&, const Split&, const std::vector<LocalMap<Dim>>&,  \
                                         const ConvexityOptions&, const std::stop_token&);                  \
  template Expected<Convexity> convexity(const SubmapSet<Dim>&, const ConvexityOptions&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
