// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/model/log_order.hpp>
#include <mapjoin/parallel/parallel.hpp>

namespace mapjoin {
namespace {

template <typename Id>
Index index_of(const std::vector<Id>& names, const Id& id) {
  return static_cast<Index>(position_of(names, id));
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
    const std::size_t i = position_of(names, item.id);
    if (column.given[i]) return bad_input(fmt::format("{} has two {}", to_string(item.id), what));
    column.values[i] = item.value;
    column.given[i] = true;
  }
  column.count = said.size();
  return column;
}

template <int Dim>
bool same(const Pose<Dim>& a, const Pose<Dim>& b) {
  return a.translation == b.translation && a.rotation.matrix() == b.rotation.matrix();
}

/// In the order of their pose, each once; a pose may be fixed twice only at the same place.
template <int Dim>
Expected<std::vector<FixedPose<Dim>>> sorted_once(std::vector<FixedPose<Dim>> fixed, const std::vector<PoseId>& poses) {
  std::stable_sort(fixed.begin(), fixed.end(), [](const auto& a, const auto& b) { return a.pose < b.pose; });
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

template <int Dim>
void LogBuilder<Dim>::reserve(std::size_t pose_edges, std::size_t observations) {
  edge_ends_.reserve(pose_edges);
  log_.odometry.reserve(pose_edges);
  observation_ends_.reserve(observations);
  log_.observations.reserve(observations);
}

template <int Dim>
void LogBuilder<Dim>::add_pose(PoseId id, const std::optional<Pose<Dim>>& initial) {
  poses_.mention(id);
  if (initial) initial_poses_.push_back({id, *initial});
}

template <int Dim>
void LogBuilder<Dim>::add_feature(FeatureId id, const std::optional<Point<Dim>>& initial) {
  features_.mention(id);
  if (initial) initial_features_.push_back({id, *initial});
}

template <int Dim>
void LogBuilder<Dim>::add_stamp(PoseId id, std::int64_t nanoseconds) {
  poses_.mention(id);
  stamps_.push_back({id, nanoseconds});
}

template <int Dim>
void LogBuilder<Dim>::add_pose_edge(PoseId base, PoseId target, const Pose<Dim>& measured, const PoseMatrix<Dim>& information) {
  poses_.mention(base);
  poses_.mention(target);
  edge_ends_.emplace_back(base, target);
  log_.odometry.push_back({0, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::add_observation(PoseId pose, FeatureId feature, const Point<Dim>& measured,
                                      const PointMatrix<Dim>& information) {
  poses_.mention(pose);
  features_.mention(feature);
  observation_ends_.emplace_back(pose, feature);
  log_.observations.push_back({0, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::add_pose_prior(PoseId pose, const Pose<Dim>& measured, const PoseMatrix<Dim>& information) {
  poses_.mention(pose);
  pose_prior_ends_.push_back(pose);
  log_.pose_priors.push_back({kWorld, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::add_feature_prior(FeatureId feature, const Point<Dim>& measured, const PointMatrix<Dim>& information) {
  features_.mention(feature);
  feature_prior_ends_.push_back(feature);
  log_.feature_priors.push_back({kWorld, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::fix(PoseId id, const std::optional<Pose<Dim>>& value) {
  fixed_.push_back({id, value});
}

template <int Dim>
Expected<Log<Dim>> LogBuilder<Dim>::finish() && {
  log_.poses = poses_.take();
  log_.features = features_.take();
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
  const auto resolve = [](const auto& ends, const auto& bases, const auto& targets, auto& observations) {
    parallel_chunks(ends.size(), kObservationsPerPiece, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        observations[i].base = index_of(bases, ends[i].first);
        observations[i].target = index_of(targets, ends[i].second);
      }
    });
  };
  resolve(edge_ends_, log_.poses, log_.poses, log_.odometry);
  resolve(observation_ends_, log_.poses, log_.features, log_.observations);
  for (std::size_t i = 0; i < pose_prior_ends_.size(); ++i) {
    log_.pose_priors[i].target = index_of(log_.poses, pose_prior_ends_[i]);
  }
  for (std::size_t i = 0; i < feature_prior_ends_.size(); ++i) {
    log_.feature_priors[i].target = index_of(log_.features, feature_prior_ends_[i]);
  }
  put_in_order(log_);
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

  auto fixed = resolve_fixed(poses->values);
  if (!fixed) return tl::unexpected(fixed.error());

  log_.fixed = *std::move(fixed);
  log_.stamps_ns = std::move(stamps->values);
  if (poses->count == log_.poses.size()) log_.initial_poses = std::move(poses->values);
  if (features->count == log_.features.size()) log_.initial_features = std::move(features->values);
  return {};
}

template <int Dim>
Expected<std::vector<FixedPose<Dim>>> LogBuilder<Dim>::resolve_fixed(const std::vector<Pose<Dim>>& initial_poses) const {
  std::vector<FixedPose<Dim>> fixed;
  for (const auto& [id, value] : fixed_) {
    if (!contains(log_.poses, id)) {
      return bad_input(fmt::format("{} is fixed, but the log has no such pose (features cannot be fixed)", to_string(id)));
    }
    const std::size_t i = position_of(log_.poses, id);
    const Pose<Dim> otherwise = initial_poses.empty() ? Pose<Dim>{} : initial_poses[i];
    fixed.push_back({static_cast<Index>(i), value.value_or(otherwise)});
  }
  return sorted_once(std::move(fixed), log_.poses);
}

template class LogBuilder<2>;
template class LogBuilder<3>;

}  // namespace mapjoin
