// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <mapjoin/model/log_builder.hpp>

namespace mapjoin {
namespace {

template <typename T, typename Less>
void stable_sort_unless_sorted(std::vector<T>& items, Less less) {
  if (!std::is_sorted(items.begin(), items.end(), less)) std::stable_sort(items.begin(), items.end(), less);
}

/// Every id once, in ascending order.
template <typename Id>
std::vector<Id> names_of(std::vector<Id>& mentions) {
  if (!std::is_sorted(mentions.begin(), mentions.end())) std::sort(mentions.begin(), mentions.end());
  mentions.erase(std::unique(mentions.begin(), mentions.end()), mentions.end());
  mentions.shrink_to_fit();
  return std::move(mentions);
}

/// The index of `id` among the ascending `names`, of which it is one. Constant time where keys are consecutive.
template <typename Id>
Index index_of(const std::vector<Id>& names, const Id& id) {
  const std::uint64_t guess = id.key - names.front().key;
  if (guess < names.size() && names[guess] == id) return static_cast<Index>(guess);
  return static_cast<Index>(std::lower_bound(names.begin(), names.end(), id) - names.begin());
}

/// What was said of each id, by its index.
template <typename Value>
struct Column {
  std::vector<Value> values;
  std::vector<bool> given;
  std::size_t count = 0;
};

template <typename Value, typename Id, typename Said>
Expected<Column<Value>> column_of(const std::vector<Said>& said, const std::vector<Id>& names, const char* what) {
  Column<Value> column;
  if (said.empty()) return column;
  column.values.resize(names.size());
  column.given.resize(names.size());
  for (const Said& item : said) {
    const auto i = static_cast<std::size_t>(index_of(names, item.id));
    if (column.given[i]) return bad_input(fmt::format("{} has two {}", to_string(item.id), what));
    column.values[i] = item.value;
    column.given[i] = true;
  }
  column.count = said.size();
  return column;
}

/// An edge between successive poses of one of the user's sessions.
template <int Dim>
bool is_odometry(const PoseObservation<Dim>& edge, const std::vector<PoseId>& poses) {
  const Index first = std::min(edge.base, edge.target);
  const Index second = std::max(edge.base, edge.target);
  return second == first + 1 &&
         poses[static_cast<std::size_t>(first)].session == poses[static_cast<std::size_t>(second)].session;
}

template <int Dim>
Index later_pose(const PoseObservation<Dim>& edge) {
  return std::max(edge.base, edge.target);
}

/// The number of edges beyond the first between the same two poses, whatever their direction.
template <int Dim>
std::int64_t count_repeated(const std::vector<PoseObservation<Dim>>& edges) {
  std::vector<std::pair<Index, Index>> ends;
  ends.reserve(edges.size());
  for (const auto& edge : edges) ends.emplace_back(std::minmax(edge.base, edge.target));
  std::sort(ends.begin(), ends.end());
  return ends.end() - std::unique(ends.begin(), ends.end());
}

/// Parts log.odometry, which holds all edges, into odometry and closures.
template <int Dim>
void part_edges(Log<Dim>& log) {
  auto& edges = log.odometry;
  log.repeated_edges = count_repeated(edges);
  const auto closures =
      std::stable_partition(edges.begin(), edges.end(), [&](const auto& edge) { return is_odometry(edge, log.poses); });
  log.closures.assign(closures, edges.end());
  edges.erase(closures, edges.end());
  stable_sort_unless_sorted(edges, [](const auto& a, const auto& b) { return later_pose(a) < later_pose(b); });
}

/// Poses that odometry ties to their predecessor belong to its session, every other one starts a session.
template <int Dim>
std::vector<Session> sessions_of(const Log<Dim>& log) {
  std::vector<Session> sessions{{0, 1}};
  auto edge = log.odometry.begin();
  for (Index pose = 1; pose < static_cast<Index>(log.poses.size()); ++pose) {
    while (edge != log.odometry.end() && later_pose(*edge) < pose) ++edge;
    const bool tied = edge != log.odometry.end() && later_pose(*edge) == pose;
    if (!tied) sessions.push_back({pose, pose});
    sessions.back().end = pose + 1;
  }
  return sessions;
}

template <int Dim>
bool same(const Pose<Dim>& a, const Pose<Dim>& b) {
  return a.translation == b.translation && a.rotation.matrix() == b.rotation.matrix();
}

/// In the order of their pose, each once; a pose may be fixed twice only at the same place.
template <int Dim>
Expected<std::vector<FixedPose<Dim>>> sorted_once(std::vector<FixedPose<Dim>> fixed, const std::vector<PoseId>& poses) {
  stable_sort_unless_sorted(fixed, [](const auto& a, const auto& b) { return a.pose < b.pose; });
  const auto differing = std::adjacent_find(
      fixed.begin(), fixed.end(), [](const auto& a, const auto& b) { return a.pose == b.pose && !same(a.value, b.value); });
  if (differing != fixed.end()) {
    return bad_input(to_string(poses[static_cast<std::size_t>(differing->pose)]) + " is fixed at two places");
  }
  const auto same_pose = [](const auto& a, const auto& b) { return a.pose == b.pose; };
  fixed.erase(std::unique(fixed.begin(), fixed.end(), same_pose), fixed.end());
  return fixed;
}

}  // namespace

template <int Dim>
LogBuilder<Dim>::LogBuilder(std::string source, Conventions conventions) {
  log_.source = std::move(source);
  log_.conventions = conventions;
}

// Neighbouring observations mention the same pose: most repetitions are caught here, the others by names_of.
template <int Dim>
void LogBuilder<Dim>::mention(PoseId id) {
  if (pose_mentions_.empty() || pose_mentions_.back() != id) pose_mentions_.push_back(id);
}

template <int Dim>
void LogBuilder<Dim>::mention(FeatureId id) {
  if (feature_mentions_.empty() || feature_mentions_.back() != id) feature_mentions_.push_back(id);
}

template <int Dim>
void LogBuilder<Dim>::add_pose(PoseId id, const std::optional<Pose<Dim>>& initial) {
  mention(id);
  if (initial) initial_poses_.push_back({id, *initial});
}

template <int Dim>
void LogBuilder<Dim>::add_feature(FeatureId id, const std::optional<Point<Dim>>& initial) {
  mention(id);
  if (initial) initial_features_.push_back({id, *initial});
}

template <int Dim>
void LogBuilder<Dim>::add_stamp(PoseId id, std::int64_t nanoseconds) {
  mention(id);
  stamps_.push_back({id, nanoseconds});
}

template <int Dim>
void LogBuilder<Dim>::add_pose_edge(PoseId base, PoseId target, const Pose<Dim>& measured, const PoseMatrix<Dim>& information) {
  mention(base);
  mention(target);
  edge_ends_.emplace_back(base, target);
  log_.odometry.push_back({0, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::add_observation(PoseId pose, FeatureId feature, const Point<Dim>& measured,
                                      const PointMatrix<Dim>& information) {
  mention(pose);
  mention(feature);
  observation_ends_.emplace_back(pose, feature);
  log_.observations.push_back({0, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::add_pose_prior(PoseId pose, const Pose<Dim>& measured, const PoseMatrix<Dim>& information) {
  mention(pose);
  pose_prior_ends_.push_back(pose);
  log_.pose_priors.push_back({kWorld, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::add_feature_prior(FeatureId feature, const Point<Dim>& measured, const PointMatrix<Dim>& information) {
  mention(feature);
  feature_prior_ends_.push_back(feature);
  log_.feature_priors.push_back({kWorld, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::fix(PoseId id, const std::optional<Pose<Dim>>& value) {
  mention(id);
  fixed_.push_back({id, value});
}

template <int Dim>
Expected<Log<Dim>> LogBuilder<Dim>::finish() && {
  log_.poses = names_of(pose_mentions_);
  log_.features = names_of(feature_mentions_);
  return check_names()
      .and_then([&] { return check_edges(); })
      .map([&] { resolve_ends(); })
      .and_then([&] { return resolve_values(); })
      .map([&] { return std::move(log_); })
      .map_error([&](const Error& error) {
        return Error{error.kind, log_.source + ": " + error.message};
      });
}

template <int Dim>
Expected<void> LogBuilder<Dim>::check_names() const {
  if (log_.poses.empty()) return bad_input("the log has no poses");
  constexpr std::size_t kMost = std::numeric_limits<Index>::max();
  if (log_.poses.size() < kMost && log_.features.size() < kMost) return {};
  return tl::unexpected(Error{ErrorKind::kTooLarge, fmt::format("more than {} poses or features", kMost)});
}

template <int Dim>
Expected<void> LogBuilder<Dim>::check_edges() const {
  const auto is_loop = [](const auto& ends) { return ends.first == ends.second; };
  const auto loop = std::find_if(edge_ends_.begin(), edge_ends_.end(), is_loop);
  if (loop == edge_ends_.end()) return {};
  return bad_input(fmt::format("an edge leads from {} to itself", to_string(loop->first)));
}

template <int Dim>
void LogBuilder<Dim>::resolve_ends() {
  for (std::size_t i = 0; i < edge_ends_.size(); ++i) {
    log_.odometry[i].base = index_of(log_.poses, edge_ends_[i].first);
    log_.odometry[i].target = index_of(log_.poses, edge_ends_[i].second);
  }
  for (std::size_t i = 0; i < observation_ends_.size(); ++i) {
    log_.observations[i].base = index_of(log_.poses, observation_ends_[i].first);
    log_.observations[i].target = index_of(log_.features, observation_ends_[i].second);
  }
  for (std::size_t i = 0; i < pose_prior_ends_.size(); ++i) {
    log_.pose_priors[i].target = index_of(log_.poses, pose_prior_ends_[i]);
  }
  for (std::size_t i = 0; i < feature_prior_ends_.size(); ++i) {
    log_.feature_priors[i].target = index_of(log_.features, feature_prior_ends_[i]);
  }
  part_edges(log_);
  stable_sort_unless_sorted(log_.observations, [](const auto& a, const auto& b) { return a.base < b.base; });
  log_.sessions = sessions_of(log_);
}

template <int Dim>
Expected<void> LogBuilder<Dim>::resolve_values() {
  auto poses = column_of<Pose<Dim>>(initial_poses_, log_.poses, "initial values");
  if (!poses) return tl::unexpected(poses.error());
  auto features = column_of<Point<Dim>>(initial_features_, log_.features, "initial values");
  if (!features) return tl::unexpected(features.error());
  auto stamps = column_of<std::int64_t>(stamps_, log_.poses, "time stamps");
  if (!stamps) return tl::unexpected(stamps.error());
  if (stamps->count > 0 && stamps->count < log_.poses.size()) {
    return bad_input(fmt::format("only {} of {} poses have a time stamp", stamps->count, log_.poses.size()));
  }

  std::vector<FixedPose<Dim>> fixed;
  for (const auto& [id, value] : fixed_) {
    const Index pose = index_of(log_.poses, id);
    const auto i = static_cast<std::size_t>(pose);
    fixed.push_back({pose, value ? *value : poses->count > 0 ? poses->values[i] : Pose<Dim>{}});
  }
  auto fixed_once = sorted_once(std::move(fixed), log_.poses);
  if (!fixed_once) return tl::unexpected(fixed_once.error());

  log_.fixed = *std::move(fixed_once);
  log_.stamps_ns = std::move(stamps->values);
  if (poses->count == log_.poses.size()) log_.initial_poses = std::move(poses->values);
  if (features->count == log_.features.size()) log_.initial_features = std::move(features->values);
  return {};
}

template class LogBuilder<2>;
template class LogBuilder<3>;

}  // namespace mapjoin
