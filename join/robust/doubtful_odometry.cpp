// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/robust/doubtful_odometry.hpp>
#include <mapjoin/join/robust/support/closure_support.hpp>
#include <mapjoin/join/run.hpp>
#include <memory>
#include <utility>
#include <variant>

namespace mapjoin {
namespace {

/// A step is doubtful if the evidence for it (log-odds) is below this: three loops contradict it.
constexpr double kDoubtful = -3.0 * kMostOfAPair;

/// Maximum number of suspected steps that are tried, those contradicted most. The log-odds of closures must gain more than
/// kLeastGain without the step: those of both closures of three loops.
constexpr std::size_t kMostTried = 3;
constexpr double kLeastGain = 6.0 * kMostOfAPair;
/// Maximum number of verdicts on maps after which the log is cut again.
constexpr int kMostVerdicts = 3;

/// The poses after the steps that are doubtful by their evidence, ascending; of those up to `nearby` steps apart only the
/// worst: the others are not judged until it is cut.
std::vector<PoseIndex> spoken_against(const Table<PoseIndex, double>& evidence, std::int32_t nearby) {
  std::vector<PoseIndex> poses;
  const auto begin = evidence.begin();
  for (const PoseIndex p : indices(evidence)) {
    const auto first = begin + std::max(0, p.value - nearby);
    const auto last = begin + std::min(static_cast<std::int32_t>(evidence.size()), p.value + nearby + 1);
    if (evidence[p] < kDoubtful && std::min_element(first, last) == begin + p.value) poses.push_back(p);
  }
  return poses;
}

/// The poses after steps that set closures against each other, though others support both: these may be right, and the step
/// wrong.
template <int Dim>
std::vector<PoseIndex> suspected_steps(const ClosureSupport<Dim>& support) {
  const Table<PoseIndex, double> evidence = support.evidence_for_steps(ClosureSupport<Dim>::Voices::kFor);
  std::vector<PoseIndex> poses = spoken_against(evidence, support.longest_loop());
  std::ranges::stable_sort(poses, {}, [&](PoseIndex p) { return evidence[p]; });
  poses.resize(std::min(poses.size(), kMostTried));
  const double believed = support.sum_of_odds();
  std::erase_if(poses, [&](PoseIndex p) { return support.sum_of_odds(p) - believed <= kLeastGain; });
  return poses;
}

/// Cuts a log at some poses, and then until no step is doubtful; returns the screening of the cut log.
template <int Dim>
std::unique_ptr<Screening<Dim>> cut_at_doubtful_steps(Log<Dim>& cut, std::vector<PoseIndex> poses, double confidence,
                                                      const std::stop_token& stop) {
  for (;;) {
    if (!poses.empty()) cut = cut_before(cut, poses);
    auto screening = std::make_unique<Screening<Dim>>(cut, confidence, stop);
    poses = doubtful_steps(screening->closures.support);
    if (poses.empty()) return screening;
  }
}

/// Cuts a log at each of some steps if a search rejects fewer then; updates the log and what was found in it.
template <int Dim>
void try_steps(const std::vector<PoseIndex>& steps, double confidence, const SearchOf<Dim>& search, const std::stop_token& stop,
               Log<Dim>& cut, Inliers<Log<Dim>>& found) {
  for (const PoseIndex p : steps) {
    Log<Dim> tried = cut_before(cut, {p});
    auto without = search(tried, Screening<Dim>(tried, confidence, stop));
    if (!without || without->rejected.size() >= found.rejected.size()) continue;
    cut = std::move(tried);
    found = std::move(*without);
  }
}

/// The poses after odometry steps that the verdict on the map finds out of line, ascending.
template <int Dim>
Expected<std::vector<PoseIndex>> misfit_steps(const Log<Dim>& log, const RobustOptions& options, const std::stop_token& stop) {
  RunOptions join;
  join.solver.engine = options.engine;
  return run(log, join, stop).map([&](const RunResult<Dim>& joined) {
    std::vector<PoseIndex> poses;
    for (const Misfit& misfit : joined.fit.misfits) {
      if (misfit.kind == PartKind::kOdometry) poses.push_back(std::max(misfit.from, std::get<PoseIndex>(misfit.to)));
    }
    std::ranges::sort(poses);
    return poses;
  });
}

/// Marks a rejected closure as odometry if it is an odometry step of the uncut log.
template <int Dim>
void name_odometry(const Log<Dim>& log, Misfit& misfit) {
  const auto* to = std::get_if<PoseIndex>(&misfit.to);
  if (misfit.kind != PartKind::kClosure || to == nullptr) return;
  const auto [before, after] = std::minmax(misfit.from, *to);
  if (after == before + 1 && log.poses[before].session == log.poses[after].session) misfit.kind = PartKind::kOdometry;
}

}  // namespace

template <int Dim>
Log<Dim> cut_before(const Log<Dim>& log, const std::vector<PoseIndex>& poses) {
  Log<Dim> cut = log;
  std::uint32_t last_session = 0;
  for (const PoseId& id : log.poses) last_session = std::max(last_session, id.session);
  for (const PoseIndex pose : poses) {
    const std::uint32_t session = cut.poses[pose].session;
    ++last_session;
    for (PoseIndex p = pose; p < PoseIndex(cut.poses.size()) && cut.poses[p].session == session; ++p) {
      cut.poses[p].session = last_session;
    }
  }
  put_in_order(cut);
  return cut;
}

template <int Dim>
std::vector<PoseIndex> doubtful_steps(const ClosureSupport<Dim>& support) {
  return spoken_against(support.evidence_for_steps(ClosureSupport<Dim>::Voices::kAll), support.longest_loop());
}

template <int Dim>
Expected<Inliers<Log<Dim>>> without_doubtful_odometry(const Log<Dim>& log, const RobustOptions& options,
                                                      const SearchOf<Dim>& search, const std::stop_token& stop) {
  Log<Dim> cut = log;
  std::vector<PoseIndex> out_of_line;
  for (int rounds = 0;; ++rounds) {
    const auto screening = cut_at_doubtful_steps(cut, std::move(out_of_line), options.confidence, stop);
    auto found = search(cut, *screening);
    if (!found) return found;
    if (!found->rejected.empty()) {
      try_steps(suspected_steps(screening->closures.support), options.confidence, search, stop, cut, *found);
    }
    if (stop.stop_requested()) return interrupted("rejecting");
    found->input.poses = log.poses;
    put_in_order(found->input);
    auto misfits = misfit_steps(found->input, options, stop);
    if (!misfits) return tl::unexpected(misfits.error());
    std::erase_if(*misfits, [&](PoseIndex p) { return cut.poses[p].session != cut.poses[p - 1].session; });
    if (misfits->empty() || rounds == kMostVerdicts) {
      for (Rejected& rejected : found->rejected) name_odometry(log, rejected.misfit);
      return found;
    }
    out_of_line = std::move(*misfits);
  }
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                              \
  template Log<Dim> cut_before(const Log<Dim>&, const std::vector<PoseIndex>&);                                               \
  template std::vector<PoseIndex> doubtful_steps(const ClosureSupport<Dim>&);                                                 \
  template Expected<Inliers<Log<Dim>>> without_doubtful_odometry(const Log<Dim>&, const RobustOptions&, const SearchOf<Dim>&, \
                                                                 const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
