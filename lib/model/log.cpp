// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/model/faults.hpp>
#include <mapjoin/model/log.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// `items` in the stable order of `key(item)`, a number in [0, keys). O(items + keys).
template <typename T, typename Key>
std::vector<T> sorted_by(Key key, std::size_t keys, std::vector<T> items) {
  const auto less = [&](const T& a, const T& b) { return key(a) < key(b); };
  if (std::is_sorted(items.begin(), items.end(), less)) return items;
  std::vector<std::size_t> next(keys + 1);  // Where the next item of each key goes.
  for (const T& item : items) ++next[key(item) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<T> sorted(items.size());
  for (const T& item : items) sorted[next[key(item)]++] = item;
  return sorted;
}

template <typename Observation>
bool is_prior(const Observation& observation) {
  return observation.base == kWorld;
}

/// An edge between successive poses of one of the user's sessions.
template <int Dim>
bool is_odometry(const PoseFactor<Dim>& edge, const PoseIds& poses) {
  const auto [first, second] = std::minmax(edge.base, edge.target);
  return !is_prior(edge) && second == first + 1 && poses[first].session == poses[second].session;
}

/// The place of a factor in the order of a log: odometry by its later pose, then closures, then priors.
template <int Dim>
std::size_t place_of(const PoseFactor<Dim>& factor, const PoseIds& poses) {
  if (is_prior(factor)) return poses.size() + 1;
  return is_odometry(factor, poses) ? later_pose(factor).position() : poses.size();
}
/// The place of a factor in the order of a log: observations by their pose, then priors.
template <int Dim>
std::size_t place_of(const FeatureFactor<Dim>& factor, const PoseIds& poses) {
  return is_prior(factor) ? poses.size() : factor.base.position();
}

template <typename Factor>
void sort_factors(std::vector<Factor>& factors, const PoseIds& poses) {
  factors = sorted_by([&](const Factor& o) { return place_of(o, poses); }, poses.size() + 2, std::move(factors));
}

/// The factors whose base is the World, which stand last.
template <typename Observation>
std::span<const Observation> priors_of(const std::vector<Observation>& factors) {
  const auto begin = std::partition_point(factors.begin(), factors.end(), [](const auto& factor) { return !is_prior(factor); });
  return {begin, factors.end()};
}

/// Poses that odometry ties to their predecessor belong to its session, every other one starts a session.
template <int Dim>
std::vector<Session> sessions_of(const Log<Dim>& log) {
  std::vector<Session> sessions{{0, 1}};
  const auto odometry = log.odometry();
  auto edge = odometry.begin();
  for (PoseIndex pose = 1; pose < PoseIndex(log.poses.size()); ++pose) {
    while (edge != odometry.end() && later_pose(*edge) < pose) ++edge;
    const bool tied = edge != odometry.end() && later_pose(*edge) == pose;
    if (!tied) sessions.push_back({pose, pose});
    sessions.back().end = pose + 1;
  }
  return sessions;
}

template <typename Factor, typename Targets>
Expected<void> check_order(const char* kind, const std::vector<Factor>& factors, const PoseIds& poses, const Targets& targets) {
  const auto place = [&](const Factor& factor) { return place_of(factor, poses); };
  const auto ordered_end = std::ranges::is_sorted_until(factors, {}, place);
  if (ordered_end == factors.end()) return {};
  const auto k = static_cast<std::size_t>(ordered_end - factors.begin());
  return bad_input(factor_in_words(kind, k, *ordered_end, poses, targets) +
                   "is out of order: put_in_order() sorts the factors");
}

template <typename Factor, typename Targets>
Expected<void> check(const char* kind, const std::vector<Factor>& factors, const PoseIds& poses, const Targets& targets) {
  return check_factors(kind, factors, poses, targets).and_then([&] { return check_order(kind, factors, poses, targets); });
}

template <int Dim>
Expected<void> check_fixed(const std::vector<FixedPose<Dim>>& fixed, const PoseIds& poses) {
  PoseIndex before = kWorld;
  for (const auto& [pose, value] : fixed) {
    if (!indices(poses).contains(pose)) return bad_input(name_of(poses, pose) + " is fixed, but the log has no such pose");
    if (!is_valid(value)) return bad_input(name_of(poses, pose) + " is fixed at a value that is not finite, or no rotation");
    if (pose == before) return bad_input(name_of(poses, pose) + " is fixed twice");
    if (pose < before) return bad_input("its fixed poses are out of order: put_in_order() sorts them");
    before = pose;
  }
  return {};
}

Expected<void> check_sessions(const std::vector<Session>& sessions, const PoseIds& poses) {
  PoseIndex next = 0;
  for (const Session& session : sessions) {
    if (session.begin != next || session.end <= session.begin) break;
    next = session.end;
  }
  if (next == indices(poses).last) return {};
  return bad_input("its sessions do not hold every pose once, in order: put_in_order() finds them");
}

/// Bad input unless values are given of all things or of none.
template <typename Values, typename Names>
Expected<void> check_given(const char* kind, const Values& values, const Names& names) {
  if (values.empty() || values.size() == names.size()) return {};
  return bad_input(fmt::format("it has {} {} for {}", values.size(), kind, names.size()));
}

/// Bad input unless initial values are valid.
template <typename Values, typename Names>
Expected<void> check_values(const Values& values, const Names& names) {
  const auto wrong = std::ranges::find_if(values, [](const auto& value) { return !is_valid(value); });
  if (wrong == values.end()) return {};
  return bad_input(to_string(names.begin()[wrong - values.begin()]) + " has a value that is not finite, or no rotation");
}

}  // namespace

std::vector<Session> sessions_by_name(const PoseIds& poses) {
  std::vector<Session> sessions;
  for (const PoseIndex p : indices(poses)) {
    if (p == 0 || poses[p].session != poses[p - 1].session) sessions.push_back({p, p});
    sessions.back().end = p + 1;
  }
  return sessions;
}

template <int Dim>
std::span<const PoseFactor<Dim>> Log<Dim>::edges() const {
  return std::span(graph.pose_factors).first(graph.pose_factors.size() - pose_priors().size());
}

template <int Dim>
std::span<const PoseFactor<Dim>> Log<Dim>::odometry() const {
  const auto end = std::partition_point(graph.pose_factors.begin(), graph.pose_factors.end(),
                                        [&](const auto& edge) { return is_odometry(edge, poses); });
  return {graph.pose_factors.begin(), end};
}

template <int Dim>
std::span<const PoseFactor<Dim>> Log<Dim>::closures() const {
  return edges().subspan(odometry().size());
}

template <int Dim>
std::span<const PoseFactor<Dim>> Log<Dim>::pose_priors() const {
  return priors_of(graph.pose_factors);
}

template <int Dim>
std::span<const FeatureFactor<Dim>> Log<Dim>::observations() const {
  return std::span(graph.feature_factors).first(graph.feature_factors.size() - feature_priors().size());
}

template <int Dim>
std::span<const FeatureFactor<Dim>> Log<Dim>::feature_priors() const {
  return priors_of(graph.feature_factors);
}

template <int Dim>
bool Log<Dim>::is_held() const {
  return !graph.fixed.empty() || !pose_priors().empty() || !feature_priors().empty();
}

template <int Dim>
void put_in_order(Log<Dim>& log) {
  sort_factors(log.graph.pose_factors, log.poses);
  sort_factors(log.graph.feature_factors, log.poses);
  std::ranges::stable_sort(log.graph.fixed, {}, &FixedPose<Dim>::pose);
  log.repeated_edges = count_repeated(log.edges());
  log.sessions = sessions_of(log);
}

template <int Dim>
Expected<void> check_invariants(const Log<Dim>& log) {
  if (log.poses.empty()) return bad_input_of(log.source, "there are no poses");
  const auto checked =
      check_names(log.poses)
          .and_then([&] { return check_names(log.features); })
          .and_then([&] { return check("pose factor", log.graph.pose_factors, log.poses, log.poses); })
          .and_then([&] { return check("feature factor", log.graph.feature_factors, log.poses, log.features); })
          .and_then([&] { return check_fixed(log.graph.fixed, log.poses); })
          .and_then([&] { return check_sessions(log.sessions, log.poses); })
          .and_then([&] { return check_given("time stamps of poses", log.stamps_ns, log.poses); })
          .and_then([&] { return check_given("initial values of poses", log.initial.poses, log.poses); })
          .and_then([&] { return check_given("initial values of features", log.initial.features, log.features); })
          .and_then([&] { return check_values(log.initial.poses, log.poses); })
          .and_then([&] { return check_values(log.initial.features, log.features); });
  if (!checked) return bad_input_of(log.source, checked.error().message);
  if (!log.graph.submaps.empty()) return bad_input_of(log.source, "a log has no local maps: a SubmapSet has");
  return {};
}

template struct Log<2>;
template struct Log<3>;
template void put_in_order(Log<2>&);
template void put_in_order(Log<3>&);
template Expected<void> check_invariants(const Log<2>&);
template Expected<void> check_invariants(const Log<3>&);

}  // namespace mapjoin
