// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mapjoin/gps/fixes.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The robot at the time of a fix: a pose, and the robot in its frame.
template <int Dim>
struct Carrier {
  PoseIndex pose = 0;
  Pose<Dim> robot;
};

/// A share of a motion at constant speeds along it and about its axis.
template <int Dim>
Pose<Dim> share_of(const Pose<Dim>& motion, double share) {
  return {share * motion.translation, Rotation<Dim>::exp(share * motion.rotation.log())};
}

/// The poses of a log by their names and by their times.
template <int Dim>
class Poses {
 public:
  Poses(const Log<Dim>& log, double most_apart)
      : log_(log), most_apart_ns_(std::llround(1e9 * std::min(most_apart, 1e9))), steps_(log.poses.size()) {
    for (const PoseIndex p : indices(log.poses)) by_key_.emplace(log.poses[p].key, p);
    for (const PoseIndex p : indices(log.stamps_ns)) by_time_[log.poses[p].session].emplace_back(log.stamps_ns[p], p);
    for (auto& [session, poses] : by_time_) std::ranges::sort(poses);
    for (const auto& step : log.odometry()) steps_[later_pose(step)] = &step;
  }

  /// All carriers that a fix may have.
  std::vector<Carrier<Dim>> carriers_of(const GpsFix& fix) const {
    std::vector<Carrier<Dim>> carriers;
    if (const auto* key = std::get_if<std::uint64_t>(&fix.when)) {
      const auto [begin, end] = by_key_.equal_range(*key);
      for (auto found = begin; found != end; ++found) {
        if (fix.session.value_or(log_.poses[found->second].session) != log_.poses[found->second].session) continue;
        carriers.push_back({found->second, {}});
      }
      return carriers;
    }
    for (const auto& [session, poses] : by_time_) {
      if (fix.session.value_or(session) != session) continue;
      if (const auto carrier = at_time(std::get<std::int64_t>(fix.when), poses)) carriers.push_back(*carrier);
    }
    return carriers;
  }

 private:
  using Timed = std::pair<std::int64_t, PoseIndex>;

  std::optional<Carrier<Dim>> at_time(std::int64_t time, const std::vector<Timed>& poses) const {
    const auto after = std::ranges::lower_bound(poses, time, {}, &Timed::first);
    if (after == poses.end()) return std::nullopt;
    if (after->first == time) return Carrier<Dim>{after->second, {}};
    if (after == poses.begin()) return std::nullopt;
    const auto [time_before, before] = *std::prev(after);
    const auto motion = motion_between(before, after->second);
    const std::int64_t apart = std::min(time - time_before, after->first - time);
    if (!motion || apart > most_apart_ns_) return std::nullopt;
    const double share = static_cast<double>(time - time_before) / static_cast<double>(after->first - time_before);
    const Pose<Dim> moved = share_of(*motion, share);
    if (share <= 0.5) return Carrier<Dim>{before, moved};
    return Carrier<Dim>{after->second, between(*motion, moved)};
  }
  /// The motion between two poses by odometry; nullopt unless one edge ties them.
  std::optional<Pose<Dim>> motion_between(PoseIndex from, PoseIndex to) const {
    const PoseFactor<Dim>* const step = to == from + 1 ? steps_[to] : nullptr;
    if (!step) return std::nullopt;
    return step->base == from ? step->measured : inverse(step->measured);
  }

  const Log<Dim>& log_;
  std::int64_t most_apart_ns_;
  std::multimap<std::uint64_t, PoseIndex> by_key_;
  std::map<std::uint32_t, std::vector<Timed>> by_time_;
  Table<PoseIndex, const PoseFactor<Dim>*> steps_;  // by the later pose
};

/// The median of each coordinate, robust to fixes that are far off.
GeographicPoint middle_of(const std::vector<GpsFix>& fixes) {
  const auto median_of = [&](double GeographicPoint::*coordinate) {
    std::vector<double> all;
    for (const GpsFix& fix : fixes) all.push_back(fix.place.*coordinate);
    return median(std::move(all));
  };
  return {median_of(&GeographicPoint::latitude), median_of(&GeographicPoint::longitude), median_of(&GeographicPoint::height)};
}

template <int Dim>
PoseFactor<Dim> prior_of(const GpsFix& fix, const Carrier<Dim>& carrier, const Point<Dim>& lever,
                         const GeographicFrame& frame) {
  GeographicPoint place = fix.place;
  if (Dim == 2) place.height = frame.origin().height;
  Matrix<3> R;
  const Point<3> measured = frame.to_local(place, &R);
  const Vector<3> variances = fix.deviation.cwiseAbs2();
  const Matrix<Dim> covariance = Matrix<3>(R * variances.asDiagonal() * R.transpose()).topLeftCorner<Dim, Dim>();
  PoseFactor<Dim> prior{kWorld, carrier.pose, {}, PoseMatrix<Dim>::Zero(), {}, transform(carrier.robot, lever)};
  prior.measured.translation = measured.head<Dim>();
  const Matrix<Dim> W = covariance.inverse();
  prior.information.template topLeftCorner<Dim, Dim>() = 0.5 * (W + W.transpose());
  return prior;
}

/// True if the numbers of a fix are those of a place on the earth, known to some accuracy.
bool is_sound(const GpsFix& fix, bool has_height) {
  return kLatitudes.contains(fix.place.latitude) && kLongitudes.contains(fix.place.longitude) &&
         kHeights.contains(fix.place.height) && kDeviations.contains(fix.deviation.x()) &&
         kDeviations.contains(fix.deviation.y()) && (!has_height || kDeviations.contains(fix.deviation.z()));
}

Expected<void> check_numbers(const GpsFixes& fixes) {
  if (fixes.fixes.empty()) return bad_input_of(fixes.source, "there are no fixes");
  const auto wrong = std::ranges::find_if(fixes.fixes, [&](const GpsFix& fix) { return !is_sound(fix, fixes.has_heights); });
  if (wrong == fixes.fixes.end()) return {};
  return bad_input(
      fmt::format("{}:{}: a fix has a latitude up to 90, a longitude up to 360 degrees and standard deviations above 0",
                  fixes.source, wrong->line));
}

template <int Dim>
Expected<void> check_use(const GpsFixes& fixes, const Log<Dim>& log) {
  const auto wrong = [&](std::string why) { return tl::unexpected(Error{ErrorKind::kUsage, fixes.source + ": " + why}); };
  if (!log.pose_priors().empty() || !log.feature_priors().empty()) {
    return wrong(log.source + " has priors, which are in another frame than the fixes: leave out the ones or the others");
  }
  if (Dim == 3 && !fixes.has_heights) return wrong("a map in space takes columns height and sd_up");
  const bool are_by_time = std::ranges::any_of(fixes.fixes, [](const GpsFix& fix) { return fix.when.index() == 0; });
  if (!are_by_time || !log.stamps_ns.empty()) return {};
  return wrong("its fixes have times, and the poses of " + log.source +
               " have none: --stamps gives them some, or a column pose names the pose of each fix");
}

}  // namespace

std::vector<std::string> GpsOptions::validate() const {
  std::vector<std::string> violations;
  if (!std::ranges::all_of(lever, [](double coordinate) { return kLevers.contains(coordinate); })) {
    violations.push_back(
        fmt::format("the coordinates of an antenna's lever must be from {:g} to {:g} m", kLevers.least, kLevers.most));
  }
  if (!(most_apart >= 0.0)) violations.emplace_back("the time that a fix and a pose may be apart must not be negative");
  return violations;
}

template <int Dim>
Expected<AttachedFixes> attach_fixes(const GpsFixes& fixes, const GpsOptions& options, Log<Dim>& log) {
  demand_valid(options);
  const auto fit =
      check_numbers(fixes).and_then([&] { return check_invariants(log); }).and_then([&] { return check_use(fixes, log); });
  if (!fit) return tl::unexpected(fit.error());
  const Poses<Dim> poses(log, options.most_apart);
  AttachedFixes attached{GeographicFrame(middle_of(fixes.fixes)), {}, 0};
  std::vector<PoseFactor<Dim>> priors;
  for (const GpsFix& fix : fixes.fixes) {
    const std::vector<Carrier<Dim>> carriers = poses.carriers_of(fix);
    if (carriers.size() > 1) {
      return bad_input(fmt::format("{}:{}: {} and {} could both have made this fix; a column session says whose it is",
                                   fixes.source, fix.line, to_string(log.poses[carriers[0].pose]),
                                   to_string(log.poses[carriers[1].pose])));
    }
    if (carriers.empty()) {
      ++attached.left_out;
      continue;
    }
    priors.push_back(prior_of<Dim>(fix, carriers.front(), options.lever.head<Dim>(), attached.frame));
    attached.lines.push_back(fix.line);
  }
  if (priors.empty()) {
    return bad_input(fmt::format("{}: no fix is at a pose of {} or within {:.6g} s of one, between two that odometry ties",
                                 fixes.source, log.source, options.most_apart));
  }
  log.graph.pose_factors.insert(log.graph.pose_factors.end(), priors.begin(), priors.end());
  if (!log.graph.fixed.empty()) {
    log.skipped["fixed poses, for the fixes hold the map"] += static_cast<std::int64_t>(log.graph.fixed.size());
    log.graph.fixed.clear();
  }
  return attached;
}

template Expected<AttachedFixes> attach_fixes(const GpsFixes&, const GpsOptions&, Log<2>&);
template Expected<AttachedFixes> attach_fixes(const GpsFixes&, const GpsOptions&, Log<3>&);

}  // namespace mapjoin
