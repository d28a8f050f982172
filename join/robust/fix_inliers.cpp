// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/robust/fix_inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/model/loss.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

/// So many alignments are tried: of half wrong fixes, one of two right ones is missed with a probability of 1e-37, of three
/// 2e-17.
constexpr int kAlignments = 300;
/// Graduated non-convexity ends before a loss of this share, which is as good as cut off.
constexpr double kSharpShare = 0.98;

/// A log whose pose priors, all fixes, are doubtful.
template <int Dim>
class FixSearch {
 public:
  FixSearch(const Log<Dim>& log, const RobustOptions& options, const std::stop_token& stop)
      : log_(log), engine_(options.engine), stop_(stop), count_(static_cast<double>(log.pose_priors().size())) {
    widest_ = chi_squared_upper_quantile((1.0 - options.confidence) / std::max(1.0, count_), Dim);
  }

  Expected<std::vector<RejectedFix>> all() {
    if (auto start = solve_without_fixes(); !start) return tl::unexpected(start.error());
    const auto alignment = least_median_alignment();
    if (!alignment) return std::vector<RejectedFix>();
    log_.initial = moved(*alignment, std::move(log_.initial));
    return graduate().and_then([&] { return settle(); }).map([&] { return rejected(); }).map_error([&](const Error& error) {
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

  /// Of the map onto the fixes; nothing where no few of them determine one.
  std::optional<Pose<Dim>> least_median_alignment() const {
    std::vector<Point<Dim>> antennas;
    std::vector<Point<Dim>> measured;
    for (const PoseFactor<Dim>& fix : log_.pose_priors()) {
      antennas.push_back(transform(log_.initial.poses[fix.target], fix.lever));
      measured.push_back(fix.measured.translation);
    }
    RandomStream random(1, 0);
    std::optional<Pose<Dim>> best;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < kAlignments; ++k) {
      std::vector<Point<Dim>> from, to;
      for (int i = 0; i < Dim; ++i) {
        const auto chosen = static_cast<std::size_t>(random.uniform(0.0, count_));
        from.push_back(antennas[chosen]);
        to.push_back(measured[chosen]);
      }
      const auto alignment = rigid_alignment<Dim>(from, to);
      if (!alignment) continue;
      std::vector<double> distances;
      for (std::size_t f = 0; f < antennas.size(); ++f) {
        distances.push_back((transform(*alignment, antennas[f]) - measured[f]).squaredNorm());
      }
      const double middle = median(std::move(distances));
      if (middle >= least) continue;
      least = middle;
      best = alignment;
    }
    return best;
  }

  /// By graduated non-convexity, a step for each loss.
  Expected<void> graduate() {
    const double excess = std::ranges::max(costs()) / widest_;
    for (double share = first_share(excess); share < kSharpShare; share = sharper(share)) {
      for (PoseFactor<Dim>& fix : fixes()) fix.loss = Loss::truncated(widest_, share);
      if (auto solved = solve_on(1); !solved) return solved;
    }
    return {};
  }

  /// Solves with those that cost less than they may.
  Expected<void> settle() {
    const std::vector<double> all = costs();
    for (std::size_t f = 0; f < all.size(); ++f) fixes()[f].loss = all[f] < widest_ ? Loss{} : Loss{0.0, 0.0};
    return solve_on(MinimiseOptions{}.max_iterations);
  }

  /// From the values that there are.
  Expected<void> solve_on(int most_steps) {
    RunOptions options = without_verdict();
    options.solver.engine = engine_;
    options.solver.max_iterations = most_steps;
    options.schedule = Schedule::kBatch;
    options.start = Start::kFile;
    return solve(log_, options, stop_).map([&](RunResult<Dim>&& result) { take_values(std::move(result)); });
  }

  void take_values(RunResult<Dim>&& result) { log_.initial = {std::move(result.map.poses), std::move(result.map.features)}; }

  /// Without fixes the log was solved: something is free to move because too few of them count.
  Error too_few() const {
    return {ErrorKind::kBadInput, log_.source +
                                      ": too few fixes agree to hold the map; without --robust all of them do, and the "
                                      "verdict names those that are out of line"};
  }

  /// Of each fix, whatever its loss.
  std::vector<double> costs() const {
    std::vector<double> all;
    for (PoseFactor<Dim> fix : log_.pose_priors()) {
      fix.loss = {};
      all.push_back(cost(fix, Pose<Dim>{}, log_.initial.poses[fix.target]));
    }
    return all;
  }

  std::vector<RejectedFix> rejected() const {
    std::vector<RejectedFix> wrong;
    const std::vector<double> all = costs();
    for (std::size_t f = 0; f < all.size(); ++f) {
      if (all[f] >= widest_) wrong.push_back({f, all[f], std::min(1.0, count_ * chi_squared_upper_tail(all[f], Dim))});
    }
    return wrong;
  }

  std::span<PoseFactor<Dim>> fixes() { return std::span(log_.graph.pose_factors).subspan(log_.edges().size()); }

  Log<Dim> log_;
  Engine engine_;
  const std::stop_token& stop_;
  double count_;
  double widest_;  // what the confidence allows
};

}  // namespace

template <int Dim>
Expected<std::vector<RejectedFix>> find_wrong_fixes(const Log<Dim>& log, const RobustOptions& options,
                                                    const std::stop_token& stop) {
  demand_valid(options);
  if (log.pose_priors().empty()) return std::vector<RejectedFix>();
  return FixSearch<Dim>(log, options, stop).all();
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
