// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <mapjoin/model/driving_order.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/parallel/parallel.hpp>

namespace mapjoin {
namespace {

/// What is wrong with the numbers of an observation, to follow its name.
template <typename Observation>
std::optional<std::string> fault(Observation& observation, InformationCheck& check) {
  if (!is_valid(observation.measured)) return "has a measurement that is not finite, or no rotation";
  const auto fault = check.fault(observation.information);
  return fault ? std::optional("has an information matrix that " + *fault) : std::nullopt;
}

std::string name_of(PoseId base, PoseId target) {
  return fmt::format("the edge from {} to {}", to_string(base), to_string(target));
}
std::string name_of(PoseId base, FeatureId target) {
  return fmt::format("the observation of {} from {}", to_string(target), to_string(base));
}

/// The factors are between what stands at their place in `ends`.
template <typename Factor, typename Ends>
Expected<void> check_all(std::vector<Factor>& factors, const Ends& ends, InformationCheck& check) {
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const auto wrong = fault(factors[i], check);
    if (!wrong) continue;
    const auto& [base, target] = ends[i];
    const bool is_prior = factors[i].base == kWorld;
    return bad_input(fmt::format("{} {}", is_prior ? "the prior of " + to_string(target) : name_of(base, target), *wrong));
  }
  return {};
}

template <typename Item>
void append_to(std::vector<Item>& items, const std::vector<Item>& more) {
  items.insert(items.end(), more.begin(), more.end());
}

/// The index of an id that is there.
template <typename Index, typename Id>
Index index_of(const Table<Index, Id>& names, const Id& id) {
  return Index(*find_ascending(names, id));
}

template <int Dim>
bool same(const Pose<Dim>& a, const Pose<Dim>& b) {
  return a.translation == b.translation && a.rotation.matrix() == b.rotation.matrix();
}

/// In the order of their pose, each once; a pose may be fixed twice only at the same place.
template <int Dim>
Expected<std::vector<FixedPose<Dim>>> sorted_once(std::vector<FixedPose<Dim>> fixed, const PoseIds& poses) {
  std::stable_sort(fixed.begin(), fixed.end(), [](const auto& a, const auto& b) { return a.pose < b.pose; });
  const auto differing = std::adjacent_find(
      fixed.begin(), fixed.end(), [](const auto& a, const auto& b) { return a.pose == b.pose && !same(a.value, b.value); });
  if (differing != fixed.end()) {
    return bad_input(to_string(poses[differing->pose]) + " is fixed at two places");
  }
  const auto same_pose = [](const auto& a, const auto& b) { return a.pose == b.pose; };
  fixed.erase(std::unique(fixed.begin(), fixed.end(), same_pose), fixed.end());
  return fixed;
}

}  // namespace

template <int Dim>
template <typename Index, typename Value, typename Id>
auto LogBuilder<Dim>::column_of(const std::vector<Said<Id, Value>>& said, const Table<Index, Id>& names, const char* what)
    -> Expected<Column<Index, Value>> {
  Column<Index, Value> column;
  if (said.empty()) return column;
  column.values.resize(names.size());
  column.given.resize(names.size());
  for (const auto& item : said) {
    const Index i = index_of(names, item.id);
    if (column.given[i]) return bad_input(fmt::format("{} has two {}", to_string(item.id), what));
    column.values[i] = item.value;
    column.given[i] = true;
  }
  column.count = said.size();
  return column;
}

template <int Dim>
LogBuilder<Dim>::LogBuilder(std::string source, Conventions conventions, Numbers numbers) : numbers_(numbers) {
  log_.source = std::move(source);
  log_.conventions = conventions;
}

template <int Dim>
void LogBuilder<Dim>::reserve(std::size_t pose_edges, std::size_t observations) {
  pose_ends_.reserve(pose_edges);
  log_.graph.pose_factors.reserve(pose_edges);
  feature_ends_.reserve(observations);
  log_.graph.feature_factors.reserve(observations);
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
  pose_ends_.emplace_back(base, target);
  log_.graph.pose_factors.push_back({0, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::add_observation(PoseId pose, FeatureId feature, const Point<Dim>& measured,
                                      const PointMatrix<Dim>& information) {
  poses_.mention(pose);
  features_.mention(feature);
  feature_ends_.emplace_back(pose, feature);
  log_.graph.feature_factors.push_back({0, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::add_pose_prior(PoseId pose, const Pose<Dim>& measured, const PoseMatrix<Dim>& information) {
  poses_.mention(pose);
  pose_ends_.emplace_back(PoseId{}, pose);
  log_.graph.pose_factors.push_back({kWorld, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::add_feature_prior(FeatureId feature, const Point<Dim>& measured, const PointMatrix<Dim>& information) {
  features_.mention(feature);
  feature_ends_.emplace_back(PoseId{}, feature);
  log_.graph.feature_factors.push_back({kWorld, 0, measured, information});
}

template <int Dim>
void LogBuilder<Dim>::fix(PoseId id, const std::optional<Pose<Dim>>& value) {
  fixed_.push_back({id, value});
}

template <int Dim>
void LogBuilder<Dim>::append(const LogBuilder& other) {
  poses_.mention_all(other.poses_);
  features_.mention_all(other.features_);
  append_to(pose_ends_, other.pose_ends_);
  append_to(feature_ends_, other.feature_ends_);
  append_to(log_.graph.pose_factors, other.log_.graph.pose_factors);
  append_to(log_.graph.feature_factors, other.log_.graph.feature_factors);
  append_to(initial_poses_, other.initial_poses_);
  append_to(initial_features_, other.initial_features_);
  append_to(stamps_, other.stamps_);
  append_to(fixed_, other.fixed_);
  add_unassociated(other.log_.unassociated);
  add_repairs(other.log_.conventions.repairs);
}

template <int Dim>
Expected<Log<Dim>> LogBuilder<Dim>::finish(PoseOrder order) && {
  log_.poses = PoseIds(poses_.take());
  log_.features = FeatureIds(features_.take());
  return check_names()
      .and_then([&] { return check_edges(); })
      .and_then([&] { return check_numbers(); })
      .map([&] { resolve_ends(); })
      .and_then([&] { return resolve_values(); })
      .map([&] {
        if (order == PoseOrder::kDriven) take_order_of_edges(log_);
        put_in_order(log_);
        return std::move(log_);
      })
      .map_error([&](const Error& error) {
        return Error{error.kind, log_.source + ": " + error.message};
      });
}

template <int Dim>
Expected<void> LogBuilder<Dim>::check_names() const {
  if (log_.poses.empty()) return bad_input("the log has no poses");
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  if (log_.poses.size() < kMost && log_.features.size() < kMost) return {};
  return tl::unexpected(Error{ErrorKind::kTooLarge, fmt::format("more than {} poses or features", kMost)});
}

template <int Dim>
Expected<void> LogBuilder<Dim>::check_edges() const {
  for (std::size_t i = 0; i < pose_ends_.size(); ++i) {
    const auto& [base, target] = pose_ends_[i];
    if (base != target || log_.graph.pose_factors[i].base == kWorld) continue;
    return bad_input(fmt::format("an edge leads from {} to itself", to_string(base)));
  }
  return {};
}

template <int Dim>
Expected<void> LogBuilder<Dim>::check_numbers() {
  if (numbers_ == Numbers::kChecked) return {};
  InformationCheck check;
  return check_all(log_.graph.pose_factors, pose_ends_, check)
      .and_then([&] { return check_all(log_.graph.feature_factors, feature_ends_, check); })
      .and_then([&] { return check_values(); })
      .map([&] { log_.conventions.repairs += check.repairs(); });
}

template <int Dim>
Expected<void> LogBuilder<Dim>::check_values() const {
  const auto wrong = [](const auto& id) {
    return bad_input(to_string(id) + " has a value that is not finite, or no rotation");
  };
  for (const auto& [id, value] : initial_poses_) {
    if (!is_valid(value)) return wrong(id);
  }
  for (const auto& [id, value] : initial_features_) {
    if (!is_valid(value)) return wrong(id);
  }
  for (const auto& [id, value] : fixed_) {
    if (value && !is_valid(*value)) return wrong(id);
  }
  return {};
}

template <int Dim>
void LogBuilder<Dim>::resolve_ends() {
  const auto resolve = [&](const auto& ends, const auto& targets, auto& factors) {
    parallel_chunks(ends.size(), kObservationsPerPiece, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (factors[i].base != kWorld) factors[i].base = index_of(log_.poses, ends[i].first);
        factors[i].target = index_of(targets, ends[i].second);
      }
    });
  };
  resolve(pose_ends_, log_.poses, log_.graph.pose_factors);
  resolve(feature_ends_, log_.features, log_.graph.feature_factors);
}

template <int Dim>
Expected<void> LogBuilder<Dim>::resolve_values() {
  auto poses = column_of(initial_poses_, log_.poses, "initial values");
  if (!poses) return tl::unexpected(poses.error());
  auto features = column_of(initial_features_, log_.features, "initial values");
  if (!features) return tl::unexpected(features.error());
  auto stamps = column_of(stamps_, log_.poses, "time stamps");
  if (!stamps) return tl::unexpected(stamps.error());
  if (stamps->count > 0 && stamps->count < log_.poses.size()) {
    return bad_input(fmt::format("only {} of {} poses have a time stamp", stamps->count, log_.poses.size()));
  }

  auto fixed = resolve_fixed(*poses);
  if (!fixed) return tl::unexpected(fixed.error());

  log_.graph.fixed = *std::move(fixed);
  log_.stamps_ns = std::move(stamps->values);
  if (poses->count == log_.poses.size()) log_.initial.poses = std::move(poses->values);
  if (features->count == log_.features.size()) log_.initial.features = std::move(features->values);
  return {};
}

template <int Dim>
Expected<std::vector<FixedPose<Dim>>> LogBuilder<Dim>::resolve_fixed(const Column<PoseIndex, Pose<Dim>>& initial_poses) const {
  std::vector<FixedPose<Dim>> fixed;
  std::optional<PoseIndex> at_origin;  // For want of a value.
  for (const auto& [id, value] : fixed_) {
    const auto found = find_ascending(log_.poses, id);
    if (!found) {
      return bad_input(fmt::format("{} is fixed, but the log has no such pose (features cannot be fixed)", to_string(id)));
    }
    const PoseIndex pose(*found);
    const bool has_initial = initial_poses.count > 0 && initial_poses.given[pose];
    if (!value && !has_initial && at_origin.value_or(pose) != pose) {
      return bad_input(
          fmt::format("{} is fixed beside {}, but nothing says where: give it a value (in a g2o file, its vertex) or "
                      "fix one of the two only",
                      to_string(id), to_string(log_.poses[*at_origin])));
    }
    if (!value && !has_initial) at_origin = pose;
    fixed.push_back({pose, value.value_or(has_initial ? initial_poses.values[pose] : Pose<Dim>{})});
  }
  return sorted_once(std::move(fixed), log_.poses);
}

template class LogBuilder<2>;
template class LogBuilder<3>;

}  // namespace mapjoin
