// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/localmap/seen_features.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/localmap/split.hpp>
#include <stdexcept>
#include <utility>

namespace mapjoin {
namespace {

/// Grows segments along the poses of a log, by what each further pose adds.
template <int Dim>
class Growth {
 public:
  Growth(const Log<Dim>& log, const SplitOptions& options) : log_(log), options_(options), seen_(log.features.size()) {}

  /// The end of the segment that begins at `begin` in `session`.
  PoseIndex end_from(PoseIndex begin, const Session& session) {
    double amount = 0.0;
    for (PoseIndex end = begin + 1; end < session.end; ++end) {
      amount += added_by_step(end - 1, begin);
      if (amount >= options_.amount) return end;
    }
    return session.end - 1;
  }

 private:
  /// The amount, as the rule counts, that the step from `pose` adds to the segment that begins at `begin`.
  double added_by_step(PoseIndex pose, PoseIndex begin) {
    switch (options_.rule) {
      case SplitRule::kDistance:
        return step_length(pose);
      case SplitRule::kFeatures:
        return static_cast<double>(seen_.count_new(observations_of(log_, {pose, pose + 1}), begin));
      default:
        return 1.0;
    }
  }

  double step_length(PoseIndex pose) const {
    const auto step = odometry_of(log_, {pose, pose + 1});
    return step.empty() ? 0.0 : step.front().measured.translation.norm();
  }

  const Log<Dim>& log_;
  const SplitOptions& options_;
  SeenFeatures seen_;
};

/// The poses that closures, priors and the World refer to; std::out_of_range for one that the log does not have.
template <int Dim>
Table<PoseIndex, bool> referenced_poses(const Log<Dim>& log) {
  Table<PoseIndex, bool> kept(log.poses.size(), false);
  const auto keep = [&](PoseIndex pose) { kept.at(pose.position()) = true; };
  for (const auto& closure : log.closures()) {
    keep(closure.base);
    keep(closure.target);
  }
  for (const auto& prior : log.pose_priors()) keep(prior.target);
  for (const auto& fixed : log.graph.fixed) keep(fixed.pose);
  return kept;
}

/// Keeps the ends of a map, and every pose of a raw segment.
void keep(const Segment& segment, Table<PoseIndex, bool>& kept) {
  kept[segment.begin] = kept[segment.end] = true;
  for (PoseIndex pose = segment.begin + 1; !segment.is_map && pose < segment.end; ++pose) kept[pose] = true;
}

/// The most entries of a border whose block of H, a dense matrix, is handled with ease: 200 MB. There are several copies of it,
/// the rows that tie the interior to it come on top, and a map is built on every thread.
constexpr std::int64_t kMostBorder = 5000;

/// True if a map pays: it eliminates at least half of its inner poses, and its border is not too large.
template <int Dim>
bool map_pays(const Log<Dim>& log, const Segment& segment, const Table<PoseIndex, bool>& kept, SeenFeatures& seen) {
  const int inner = segment.end - segment.begin - 1;
  if (inner <= 0) return false;
  const auto first = kept.begin() + segment.begin.value + 1;
  const std::int64_t referenced = std::count(first, first + inner, true);
  const std::int64_t features = seen.count_new(observations_of(log, segment), segment.begin);
  return 2 * referenced <= inner && (2 + referenced) * kPoseDof<Dim> + features * Dim <= kMostBorder;
}

}  // namespace

std::vector<std::string> SplitOptions::validate() const {
  std::vector<std::string> violations;
  if (rule == SplitRule::kAuto && !(amount >= 0.0)) violations.emplace_back("the least number of steps must not be negative");
  if (rule == SplitRule::kPoses && !(amount >= 1.0)) violations.emplace_back("a local map needs at least one step");
  if (rule == SplitRule::kDistance && !(amount > 0.0)) violations.emplace_back("the distance of a local map must be positive");
  if (rule == SplitRule::kFeatures && !(amount >= 1.0)) violations.emplace_back("a local map needs at least one feature");
  return violations;
}

void make_raw(Segment& segment, Split& split) {
  segment.is_map = false;
  keep(segment, split.kept);
}

template <int Dim>
Split split(const Log<Dim>& log, const SplitOptions& options, const Table<PoseIndex, bool>& elsewhere) {
  demand_valid(options);
  demand_sound(check_invariants(log));
  if (!elsewhere.empty() && elsewhere.size() != log.poses.size()) {
    throw std::invalid_argument("what is referred to elsewhere must be said of every pose");
  }
  Split result;
  result.kept = referenced_poses(log);
  for (const PoseIndex p : indices(elsewhere)) result.kept[p] = result.kept[p] || elsewhere[p];
  SplitOptions chosen = options;
  if (options.rule == SplitRule::kAuto)
    chosen = {SplitRule::kPoses, static_cast<double>(cheapest_poses_per_map(log, result.kept, options.amount))};
  if (chosen.rule == SplitRule::kPoses) result.poses_per_map = static_cast<int>(std::min(chosen.amount, 1e9));
  Growth<Dim> growth(log, chosen);
  for (const Session& session : log.sessions) {
    PoseIndex begin = session.begin;
    do {
      const PoseIndex end = growth.end_from(begin, session);
      result.segments.push_back({begin, end, true});
      begin = end;
    } while (begin + 1 < session.end);
  }
  SeenFeatures seen(log.features.size());
  for (Segment& segment : result.segments) {
    segment.is_map = map_pays(log, segment, result.kept, seen);
    keep(segment, result.kept);
  }
  return result;
}

std::vector<Segment> segments_of(const Share& share, const Split& split) {
  std::vector<Segment> segments = split.segments;
  const std::size_t maps = map_segments(split.segments).size();
  std::size_t map = 0;
  for (Segment& segment : segments) {
    if (segment.is_map) segment.is_map = map++ * share.count / maps == share.index;
  }
  return segments;
}

template <int Dim>
Split split_along(const Log<Dim>& log, std::vector<Segment> segments) {
  const auto poses = indices(log.poses);
  Split result{std::move(segments), referenced_poses(log), 0};
  for (const Segment& segment : result.segments) {
    if (!poses.contains(segment.begin) || !poses.contains(segment.end)) {
      throw std::invalid_argument("a segment has poses that are not in the log");
    }
    keep(segment, result.kept);
  }
  return result;
}

template Split split(const Log<2>&, const SplitOptions&, const Table<PoseIndex, bool>&);
template Split split(const Log<3>&, const SplitOptions&, const Table<PoseIndex, bool>&);
template Split split_along(const Log<2>&, std::vector<Segment>);
template Split split_along(const Log<3>&, std::vector<Segment>);

}  // namespace mapjoin
