// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/fit/leave_one_out.hpp>
#include <mapjoin/join/robust/fix_inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/model/loss.hpp>
#include <optional>
#include <span>
#include <utility>

namespace mapjoin {
namespace {

/// Graduated non-convexity ends before a loss of this share, which is as good as cut off.
constexpr double kSharpShare = 0.98;
/// Maximum number of steps of the solve with all fixes: where these fit, they are near.
constexpr int kStepsWithAll = 20;
/// Fixes are dropped at once if they are at least this share as far (in chi2) as the farthest, which makes others seem wrong.
constexpr double kShareOfFarthestFix = 0.5;

/// Which fixes count, and the squared distance of each from its prediction by all others that do.
struct JudgedFixes {
  std::vector<bool> count;
  std::vector<double> chi2;
};

/// The squared Mahalanobis distance of each pose prior of a log from its prediction by all else that counts, at the optimum
/// `log.initial` over the rest and the priors that count, which are those without Loss::dropped(). nullopt if what counts
/// leaves something free to move.
template <int Dim>
std::optional<std::vector<PartTest>> fix_tests(Log<Dim> log, Engine engine, const std::stop_token& stop) {
  const SubmapGraph<Dim> graph = submap_graph_of(log, split(log, {SplitRule::kPoses, 1.0}), {});
  PartialMap<Dim> joined_map = joined_map_of(graph);
  joined_map.state = restricted(log.initial, joined_map);
  JoiningSystem<Dim> system(joined_map, gauge_of(graph, joined_map), engine);
  system.linearise();
  if (system.factorise(0.0)) return std::nullopt;
  const Marginals marginals(system.equations());
  std::vector<bool> counts;
  for (PoseFactor<Dim>& fix : std::span(log.graph.pose_factors).subspan(log.edges().size())) {
    counts.push_back(fix.loss != Loss::dropped());
    fix.loss = {};  // tests are of the measurements as they are
  }
  LeaveOneOut<Dim> leave_one_out(system, system.equations(), marginals);
  const std::vector<std::size_t> factors = places_among(system.pose_factors(), log.pose_priors());
  std::vector<std::size_t> counting;
  for (std::size_t f = 0; f < counts.size(); ++f) {
    if (counts[f]) counting.push_back(factors[f]);
  }
  leave_one_out.solve_for_weak(counting, stop);
  std::vector<PartTest> tests;
  for (std::size_t f = 0; f < counts.size(); ++f) tests.push_back(leave_one_out.test_whole(factors[f], counts[f]));
  return tests;
}

/// A search for outliers among the pose priors of a log, all of which are fixes, and `widest` the threshold of their chi2.
template <int Dim>
class FixSearch {
 public:
  FixSearch(const Log<Dim>& log, double widest, Engine engine, const std::stop_token& stop)
      : log_(log),
        widest_(widest),
        engine_(engine),
        stop_(stop),
        judged_{std::vector(log.pose_priors().size(), true), std::vector(log.pose_priors().size(), 0.0)} {}

  /// The fixes that count, and tests of all; all of them count if they pass as they are, or if too few stand apart to tell.
  Expected<JudgedFixes> judged() {
    if (auto start = solve_without_fixes(); !start) return tl::unexpected(start.error());
    const auto alignment = alignment_onto_fixes();
    if (!alignment) return judged_;
    log_.initial = moved(*alignment, std::move(log_.initial));
    const auto found = all_fit().and_then([&](bool fit) { return fit ? Expected<void>() : search(); });
    return found.map([&] { return judged_; }).map_error([&](const Error& error) {
      return error.kind == ErrorKind::kBadInput ? too_few() : error;
    });
  }

 private:
  Expected<void> solve_without_fixes() {
    Log<Dim> bare = log_;
    bare.graph.pose_factors.resize(bare.edges().size());
    RunOptions options = without_verdict();
    options.solver.engine = engine_;
    return run(bare, options, stop_).map([&](RunResult<Dim>&& result) { take_values(std::move(result)); });
  }

  /// The rigid motion of the map onto the fixes by least median of squares; nullopt if no sample determines one.
  std::optional<Pose<Dim>> alignment_onto_fixes() const {
    std::vector<Point<Dim>> antennas;
    std::vector<Point<Dim>> measured;
    for (const PoseFactor<Dim>& fix : log_.pose_priors()) {
      antennas.push_back(transform(log_.initial.poses[fix.target], fix.lever));
      measured.push_back(fix.measured.translation);
    }
    return least_median_alignment<Dim>(antennas, measured);
  }

  /// Solves by graduated non-convexity, with one step for each loss.
  Expected<void> graduate() {
    const double excess = std::ranges::max(costs()) / widest_;
    for (double share = first_share(excess); share < kSharpShare; share = sharper(share)) {
      for (PoseFactor<Dim>& fix : fixes()) fix.loss = Loss::truncated(widest_, share);
      if (auto solved = solve_on(1); !solved) return solved;
    }
    return {};
  }

  /// True if every fix passes its test when all count. Otherwise the estimate is as it was before.
  Expected<bool> all_fit() {
    const Values<Dim> before = log_.initial;
    const auto solved = settle(kStepsWithAll);
    if (!solved && solved.error().kind != ErrorKind::kBadInput) return tl::unexpected(solved.error());
    if (solved && std::ranges::max(judged_.chi2) < widest_) return true;
    log_.initial = before;
    return false;
  }

  /// Finds the fixes that count by graduated non-convexity, and then by tests: drops those that do not fit, and lets those in,
  /// once, that were let go only because the map was bent.
  Expected<void> search() {
    return graduate()
        .and_then([&] {
          const std::vector<double> all = costs();
          for (std::size_t f = 0; f < all.size(); ++f) judged_.count[f] = all[f] < widest_;
          return settle();
        })
        .and_then([&] { return drop_misfits(); })
        .and_then([&] { return readmit() ? settle() : Expected<void>(); })
        .and_then([&] { return drop_misfits(); });
  }

  /// Drops the fixes that fail their tests, the farthest first, until all that count pass theirs.
  Expected<void> drop_misfits() {
    while (drop_farthest()) {
      if (auto settled = settle(); !settled) return settled;
    }
    return {};
  }

  /// Drops the fixes that fail their tests and are not much nearer than the farthest. True if there were any.
  bool drop_farthest() {
    double worst = 0.0;
    for (std::size_t f = 0; f < judged_.chi2.size(); ++f) {
      if (judged_.count[f]) worst = std::max(worst, judged_.chi2[f]);
    }
    const double least = std::max(widest_, kShareOfFarthestFix * worst);
    bool any = false;
    for (std::size_t f = 0; f < judged_.chi2.size(); ++f) {
      if (!judged_.count[f] || judged_.chi2[f] < least) continue;
      judged_.count[f] = false;
      any = true;
    }
    return any;
  }

  /// Readmits the fixes that pass their tests. True if there were any.
  bool readmit() {
    bool any = false;
    for (std::size_t f = 0; f < judged_.chi2.size(); ++f) {
      if (judged_.count[f] || judged_.chi2[f] >= widest_) continue;
      judged_.count[f] = true;
      any = true;
    }
    return any;
  }

  /// Solves with the fixes that count, and tests all.
  Expected<void> settle(int most_steps = MinimiseOptions{}.max_iterations) {
    for (std::size_t f = 0; f < judged_.count.size(); ++f) fixes()[f].loss = judged_.count[f] ? Loss{} : Loss::dropped();
    if (auto solved = solve_on(most_steps); !solved) return solved;
    const auto tests = fix_tests(log_, engine_, stop_);
    if (stop_.stop_requested()) return interrupted("rejecting");
    if (!tests) return tl::unexpected(too_few());
    const std::vector<double> own = costs();  // a fix of infinite cost has no weight, and so no test
    for (std::size_t f = 0; f < own.size(); ++f) judged_.chi2[f] = std::isfinite(own[f]) ? (*tests)[f].chi2 : own[f];
    return {};
  }

  /// Solves from the current values, in at most so many steps.
  Expected<void> solve_on(int most_steps) {
    RunOptions options = without_verdict();
    options.solver.engine = engine_;
    options.solver.max_iterations = most_steps;
    options.schedule = Schedule::kBatch;
    options.start = Start::kFile;
    return solve(log_, options, stop_).map([&](RunResult<Dim>&& result) { take_values(std::move(result)); });
  }

  void take_values(RunResult<Dim>&& result) { log_.initial = {std::move(result.map.poses), std::move(result.map.features)}; }

  /// The error if too few fixes count: without fixes the log was solved, so that nothing else can leave it undetermined.
  Error too_few() const {
    return {ErrorKind::kBadInput, log_.source +
                                      ": too few fixes agree to hold the map; without --robust all of them do, and the "
                                      "verdict names those that are out of line"};
  }

  /// The cost of each fix, without its loss.
  std::vector<double> costs() const {
    std::vector<double> all;
    for (PoseFactor<Dim> fix : log_.pose_priors()) {
      fix.loss = {};
      all.push_back(cost(fix, Pose<Dim>{}, log_.initial.poses[fix.target]));
    }
    return all;
  }

  std::span<PoseFactor<Dim>> fixes() { return std::span(log_.graph.pose_factors).subspan(log_.edges().size()); }

  Log<Dim> log_;
  double widest_;
  Engine engine_;
  const std::stop_token& stop_;
  JudgedFixes judged_;
};

/// A part of a log that only fixes tie to the rest, with its fixes, and their places among the pose priors of the log.
template <int Dim>
struct FixedPart {
  Log<Dim> log;
  std::vector<std::size_t> fixes;
};

template <int Dim>
std::vector<FixedPart<Dim>> fixed_parts(const Log<Dim>& log) {
  Log<Dim> bare = log;
  bare.graph.pose_factors.resize(log.edges().size());
  std::vector<FixedPart<Dim>> parts;
  std::map<PoseId, std::pair<std::size_t, PoseIndex>> places;
  for (Log<Dim>& part : split_into_parts(bare)) {
    for (const PoseIndex pose : indices(part.poses)) places[part.poses[pose]] = {parts.size(), pose};
    parts.push_back({std::move(part), {}});
  }
  for (auto& [part, fixes] : parts) {
    if (parts.size() > 1) part.source += ", part of " + to_string(part.poses.front());  // for error messages
  }
  for (std::size_t f = 0; f < log.pose_priors().size(); ++f) {
    PoseFactor<Dim> fix = log.pose_priors()[f];
    const auto [part, pose] = places.at(log.poses[fix.target]);
    fix.target = pose;
    parts[part].log.graph.pose_factors.push_back(fix);
    parts[part].fixes.push_back(f);
  }
  return parts;
}

}  // namespace

template <int Dim>
Expected<std::vector<RejectedFix>> find_wrong_fixes(const Log<Dim>& log, const RobustOptions& options,
                                                    const std::stop_token& stop) {
  demand_valid(options);
  if (auto sound = check_invariants(log); !sound) return tl::unexpected(sound.error());
  const auto count = static_cast<double>(log.pose_priors().size());
  std::vector<RejectedFix> wrong;
  if (count == 0.0) return wrong;
  const double widest = chi_squared_upper_quantile((1.0 - options.confidence) / count, Dim);
  for (const auto& [part, fixes] : fixed_parts(log)) {
    if (fixes.empty()) continue;
    const auto judged = FixSearch<Dim>(part, widest, options.engine, stop).judged();
    if (!judged) return tl::unexpected(judged.error());
    for (std::size_t f = 0; f < fixes.size(); ++f) {
      const double tail = count * chi_squared_upper_tail(judged->chi2[f], Dim);
      if (!judged->count[f]) wrong.push_back({fixes[f], judged->chi2[f], std::min(1.0, tail)});
    }
  }
  std::ranges::sort(wrong, {}, &RejectedFix::prior);
  return wrong;
}

template <int Dim>
Log<Dim> without_fixes(const Log<Dim>& log, const std::vector<RejectedFix>& rejected) {
  Log<Dim> some = log;
  some.graph.pose_factors.resize(log.edges().size());
  auto next = rejected.begin();
  for (std::size_t f = 0; f < log.pose_priors().size(); ++f) {
    const bool is_rejected = next != rejected.end() && next->prior == f;
    is_rejected ? void(++next) : some.graph.pose_factors.push_back(log.pose_priors()[f]);
  }
  return some;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                               \
  template Expected<std::vector<RejectedFix>> find_wrong_fixes(const Log<Dim>&, const RobustOptions&, const std::stop_token&); \
  template Log<Dim> without_fixes(const Log<Dim>&, const std::vector<RejectedFix>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
