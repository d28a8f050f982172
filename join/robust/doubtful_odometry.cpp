// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/robust/closure_support.hpp>
#include <mapjoin/join/robust/doubtful_odometry.hpp>
#include <mapjoin/join/run.hpp>
#include <utility>
#include <variant>

namespace mapjoin {
namespace {

/// A step is doubtful where the evidence for it, a logarithm of odds, is below this: three loops speak against it.
constexpr double kDoubtful = -3.0 * kMostOfAPair;
/// Steps to either side of a doubtful one that are innocent till it is out.
constexpr std::int32_t kNearby = 60;

/// Steps that are tried: those that are spoken against most. The odds of closures must gain more than this without the step:
/// those of both closures of three loops.
constexpr std::size_t kMostTried = 3;
constexpr double kLeastGain = 6.0 * kMostOfAPair;
/// Verdicts on maps that are asked for odometry out of line.
constexpr int kMostVerdicts = 3;

/// The poses after the steps that are doubtful by their evidence, ascending; of neighbouring ones only the worst.
std::vector<PoseIndex> spoken_against(const Table<PoseIndex, double>& evidence) {
  std::vector<PoseIndex> poses;
  const auto begin = evidence.begin();
  for (const PoseIndex p : indices(evidence)) {
    const auto first = begin + std::max(0, p.value - kNearby);
    const auto last = begin + std::min(static_cast<std::int32_t>(evidence.size()), p.value + kNearby + 1);
    if (evidence[p] < kDoubtful && std::min_element(first, last) == begin + p.value) poses.push_back(p);
  }
  return poses;
}

/// Steps that set closures against each other which others bear out: these may be right, and the step wrong.
template <int Dim>
std::vector<PoseIndex> suspected_steps(const Log<Dim>& log, const std::stop_token& stop) {
  const OdometryChain<Dim> chain(log);
  const ClosureSupport<Dim> support(chain, log.closures(), stop);
  const Table<PoseIndex, double> evidence = support.evidence_for_steps(ClosureSupport<Dim>::Voices::kFor);
  std::vector<PoseIndex> poses = spoken_against(evidence);
  std::ranges::stable_sort(poses, {}, [&](PoseIndex p) { return evidence[p]; });
  poses.resize(std::min(poses.size(), kMostTried));
  const double believed = support.sum_of_odds();
  std::erase_if(poses, [&](PoseIndex p) { return support.sum_of_odds(p) - believed <= kLeastGain; });
  return poses;
}

/// What a search has found in a log, and the log, cut where fewer are rejected for it.
template <int Dim>
void try_suspected_steps(Log<Dim>& cut, Inliers<Log<Dim>>& found, const SearchOf<Dim>& search, const std::stop_token& stop) {
  if (found.rejected.empty()) return;
  for (const PoseIndex p : suspected_steps(cut, stop)) {
    Log<Dim> tried = cut_before(cut, {p});
    auto without = search(tried);
    if (!without || without->rejected.size() >= found.rejected.size()) continue;
    cut = std::move(tried);
    found = std::move(*without);
  }
}

/// The poses to which the verdict on a map finds odometry out of line.
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

/// Calls a closure odometry if it is in the log.
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
std::vector<PoseIndex> doubtful_steps(const Log<Dim>& log, const std::stop_token& stop) {
  const OdometryChain<Dim> chain(log);
  const ClosureSupport<Dim> support(chain, log.closures(), stop);
  return spoken_against(support.evidence_for_steps(ClosureSupport<Dim>::Voices::kAll));
}

template <int Dim>
Expected<Inliers<Log<Dim>>> without_doubtful_odometry(const Log<Dim>& log, const RobustOptions& options,
                                                      const SearchOf<Dim>& search, const std::stop_token& stop) {
  Log<Dim> cut = log;
  std::vector<PoseIndex> doubtful = doubtful_steps(log, stop);
  for (int rounds = 0;; ++rounds) {
    for (; !doubtful.empty(); doubtful = doubtful_steps(cut, stop)) cut = cut_before(cut, doubtful);
    auto found = search(cut);
    if (!found) return found;
    try_suspected_steps(cut, *found, search, stop);
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
    doubtful = std::move(*misfits);
  }
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                              \
  template Log<Dim> cut_before(const Log<Dim>&, const std::vector<PoseIndex>&);                                               \
  template std::vector<PoseIndex> doubtful_steps(const Log<Dim>&, const std::stop_token&);                                    \
  template Expected<Inliers<Log<Dim>>> without_doubtful_odometry(const Log<Dim>&, const RobustOptions&, const SearchOf<Dim>&, \
                                                                 const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
