// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <mapjoin/model/faults.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <stdexcept>

namespace mapjoin {
namespace {

std::string name_of(PoseId base, PoseId target) {
  return fmt::format("the edge from {} to {}", to_string(base), to_string(target));
}
std::string name_of(PoseId base, FeatureId target) {
  return fmt::format("the observation of {} from {}", to_string(target), to_string(base));
}

/// Checks the numbers of all factors.
template <typename Kind>
Expected<void> check_factors(Kind& kind, InformationCheck& check) {
  for (std::size_t i = 0; i < kind.factors.size(); ++i) {
    auto& factor = kind.factors[i];
    const auto wrong = fault(factor, check);
    if (!wrong) continue;
    const auto& [base, target] = kind.ends[i];
    return bad_input((factor.base == kWorld ? "the prior of " + to_string(target) : name_of(base, target)) + " " + *wrong);
  }
  return {};
}

using mapjoin::is_valid;
template <typename Value>
bool is_valid(const std::optional<Value>& value) {
  return !value || is_valid(*value);
}

template <typename Said>
Expected<void> check_values(const std::vector<Said>& said) {
  const auto wrong = std::ranges::find_if(said, [](const Said& item) { return !is_valid(item.value); });
  if (wrong == said.end()) return {};
  return bad_input(to_string(wrong->id) + " has a value that is not finite, or no rotation");
}

/// Sorts values by id; kBadInput if an id has two, which `what` names.
template <typename Said>
Expected<void> sort_once(std::vector<Said>& said, const char* what) {
  if (!std::ranges::is_sorted(said, {}, &Said::id)) std::ranges::stable_sort(said, {}, &Said::id);
  const auto twice = std::ranges::adjacent_find(said, {}, &Said::id);
  if (twice == said.end()) return {};
  return bad_input(fmt::format("{} has two {}", to_string(twice->id), what));
}

/// The values of all `names` by index, given once each in the order of ids; empty if any is missing.
template <typename Index, typename Id, typename Said>
auto values_of_all(const Table<Index, Id>& names, const std::vector<Said>& said) {
  Table<Index, decltype(Said::value)> values;
  if (said.size() < names.size()) return values;
  values.reserve(said.size());
  for (const Said& item : said) values.push_back(item.value);
  return values;
}

template <typename Item>
void append_to(std::vector<Item>& items, const std::vector<Item>& more) {
  items.insert(items.end(), more.begin(), more.end());
}

}  // namespace

template <int Dim>
template <typename Id, typename Value, typename Factor>
void LogBuilder<Dim>::Kind<Id, Value, Factor>::append(const Kind& other) {
  names.mention_all(other.names);
  append_to(factors, other.factors);
  append_to(ends, other.ends);
  append_to(initial, other.initial);
}

template <int Dim>
void LogBuilder<Dim>::append(const LogBuilder& other) {
  poses_.append(other.poses_);
  features_.append(other.features_);
  append_to(stamps_, other.stamps_);
  append_to(fixed_, other.fixed_);
  add_unassociated(other.log_.unassociated);
  for (const auto& [what, count] : other.log_.skipped) add_skipped(what, count);
  add_repairs(other.log_.conventions.repairs);
}

template <int Dim>
void LogBuilder<Dim>::append(const Log<Dim>& log, std::uint32_t first_session) {
  const auto is_beyond = [&](const PoseId& id) {
    return id.session > std::numeric_limits<std::uint32_t>::max() - first_session;
  };
  if (std::ranges::any_of(log.poses, is_beyond)) {
    throw std::out_of_range("the sessions of a log that is appended go beyond 2^32");
  }
  const auto pose = [&](PoseIndex p) {
    const PoseId& id = log.poses.at(p.position());
    return PoseId{id.session + first_session, id.key};
  };
  const auto feature = [&](FeatureIndex f) { return log.features.at(f.position()); };
  const auto base_of = [&](const auto& factor) {
    return factor.base == kWorld ? std::nullopt : std::optional(pose(factor.base));
  };
  const auto value = [](const auto& values, auto index) {
    return values.empty() ? std::nullopt : std::optional(values.at(index.position()));
  };
  reserve(log.graph.pose_factors.size(), log.graph.feature_factors.size());
  for (const PoseIndex p : indices(log.poses)) add_pose(pose(p), value(log.initial.poses, p));
  for (const FeatureIndex f : indices(log.features)) add_feature(feature(f), value(log.initial.features, f));
  for (const PoseIndex p : indices(log.stamps_ns)) add_stamp(pose(p), log.stamps_ns[p]);
  for (const auto& factor : log.graph.pose_factors) add(base_of(factor), pose(factor.target), factor);
  for (const auto& factor : log.graph.feature_factors) add(base_of(factor), feature(factor.target), factor);
  for (const auto& fixed : log.graph.fixed) fix(pose(fixed.pose), fixed.value);
  add_unassociated(log.unassociated);
  for (const auto& [what, count] : log.skipped) add_skipped(what, count);
  add_repairs(log.conventions.repairs);
}

template <int Dim>
LeftOut<Dim> LogBuilder<Dim>::take_undeclared() {
  const auto declared = [](const auto& kind) {
    std::vector<std::decay_t<decltype(kind.initial.front().id)>> ids;
    for (const auto& said : kind.initial) ids.push_back(said.id);
    std::ranges::sort(ids);
    return [ids = std::move(ids)](const auto& id) { return std::ranges::binary_search(ids, id); };
  };
  const auto has_pose = declared(poses_);
  const auto has_feature = declared(features_);
  const auto split = [&](auto& kind, const auto& has_target, const auto& take) {
    const auto all = std::exchange(kind, {});
    for (const auto& [id, value] : all.initial) kind.add(id, value);
    for (std::size_t i = 0; i < all.factors.size(); ++i) {
      const auto& [base, target] = all.ends[i];
      const bool is_declared = has_target(target) && (all.factors[i].base == kWorld || has_pose(base));
      is_declared ? kind.add(base, target, all.factors[i]) : take(base, target, all.factors[i]);
    }
  };
  LeftOut<Dim> out;
  split(poses_, has_pose, [&](PoseId base, PoseId target, const PoseFactor<Dim>& factor) {
    if (factor.base == kWorld) {
      ++out.others;
    } else {
      out.edges.push_back({base, target, factor.measured, factor.information});
    }
  });
  split(features_, has_feature, [&](const auto&...) { ++out.others; });
  std::erase_if(stamps_, [&](const auto& said) { return !has_pose(said.id); });
  const std::size_t fixed = fixed_poses().size();
  std::erase_if(fixed_, [&](const auto& said) { return !has_pose(said.id) && !has_feature(FeatureId{said.id.key}); });
  out.fixed_poses = static_cast<std::int64_t>(fixed - fixed_poses().size());
  return out;
}

template <int Dim>
std::vector<PoseId> LogBuilder<Dim>::fixed_poses() const {
  std::vector<PoseId> ids;
  for (const auto& said : fixed_) ids.push_back(said.id);
  make_distinct(ids);
  return ids;
}

template <int Dim>
Expected<Log<Dim>> LogBuilder<Dim>::finish(PoseOrder order) && {
  return finish_with([&](Log<Dim>& log) -> Expected<void> {
    if (order == PoseOrder::kDriven) take_order_of_edges(log);
    return {};
  });
}

template <int Dim>
Expected<Log<Dim>> LogBuilder<Dim>::finish(const PoseIds& order) && {
  return finish_with([&](Log<Dim>& log) { return take_order(order, log); });
}

template <int Dim>
template <typename F>
Expected<Log<Dim>> LogBuilder<Dim>::finish_with(F&& order_poses) {
  LogBuilder all = std::exchange(*this, LogBuilder(log_.source));
  Log<Dim>& log = all.log_;
  log.poses = PoseIds(all.poses_.names.take());
  log.features = FeatureIds(all.features_.names.take());
  return all.check_names()
      .and_then([&] { return all.check_edges(); })
      .and_then([&] { return all.check_numbers(); })
      .map([&] { all.resolve_ends(); })
      .and_then([&] { return all.resolve_values(); })
      .and_then([&] { return order_poses(log); })
      .map([&] {
        put_in_order(log);
        return std::move(log);
      })
      .map_error([&](const Error& error) {
        return log_.source.empty() ? error : Error{error.kind, log_.source + ": " + error.message};
      });
}

template <int Dim>
Expected<void> LogBuilder<Dim>::check_names() const {
  if (log_.poses.empty() && needs_poses_) return bad_input("the log has no poses");
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  if (log_.poses.size() < kMost && log_.features.size() < kMost) return {};
  return tl::unexpected(Error{ErrorKind::kTooLarge, fmt::format("more than {} poses or features", kMost)});
}

template <int Dim>
Expected<void> LogBuilder<Dim>::check_edges() const {
  for (std::size_t i = 0; i < poses_.ends.size(); ++i) {
    const auto& [base, target] = poses_.ends[i];
    if (base != target || poses_.factors[i].base == kWorld) continue;
    return bad_input(fmt::format("an edge leads from {} to itself", to_string(base)));
  }
  return {};
}

template <int Dim>
Expected<void> LogBuilder<Dim>::check_numbers() {
  if (numbers_ == Numbers::kChecked) return {};
  InformationCheck check;
  return check_factors(poses_, check)
      .and_then([&] { return check_factors(features_, check); })
      .and_then([&] { return check_values(poses_.initial); })
      .and_then([&] { return check_values(features_.initial); })
      .and_then([&] { return check_values(fixed_); })
      .map([&] { add_repairs(check.repairs()); });
}

template <int Dim>
void LogBuilder<Dim>::resolve_ends() {
  const auto resolve = [&](auto& kind, const auto& targets) {
    parallel_chunks(kind.ends.size(), kObservationsPerPiece, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        auto& factor = kind.factors[i];
        if (factor.base != kWorld) factor.base = PoseIndex(*find_ascending(log_.poses, kind.ends[i].first));
        factor.target = decltype(factor.target)(*find_ascending(targets, kind.ends[i].second));
      }
    });
    return std::move(kind.factors);
  };
  log_.graph.pose_factors = resolve(poses_, log_.poses);
  log_.graph.feature_factors = resolve(features_, log_.features);
}

template <int Dim>
Expected<void> LogBuilder<Dim>::resolve_values() {
  return sort_once(poses_.initial, "initial values")
      .and_then([&] { return sort_once(features_.initial, "initial values"); })
      .and_then([&] { return sort_once(stamps_, "time stamps"); })
      .and_then([&]() -> Expected<void> {
        if (stamps_.empty() || stamps_.size() == log_.poses.size()) return {};
        return bad_input(fmt::format("only {} of {} poses have a time stamp", stamps_.size(), log_.poses.size()));
      })
      .and_then([&] { return resolve_fixed(); })
      .map([&](std::vector<FixedPose<Dim>>&& fixed) {
        log_.graph.fixed = std::move(fixed);
        log_.stamps_ns = values_of_all(log_.poses, stamps_);
        log_.initial.poses = values_of_all(log_.poses, poses_.initial);
        log_.initial.features = values_of_all(log_.features, features_.initial);
      });
}

template <int Dim>
Expected<std::vector<FixedPose<Dim>>> LogBuilder<Dim>::resolve_fixed() const {
  std::vector<FixedPose<Dim>> fixed;
  std::optional<PoseId> at_origin;  // The pose without a value.
  for (const auto& [id, value] : fixed_) {
    const auto pose = find_ascending(log_.poses, id);
    if (!pose) return bad_input(fixed_without_pose(id));
    const auto initial = std::ranges::lower_bound(poses_.initial, id, {}, [](const auto& item) { return item.id; });
    const bool has_initial = initial != poses_.initial.end() && initial->id == id;
    if (!value && !has_initial && at_origin.value_or(id) != id) return bad_input(fixed_nowhere(id, *at_origin));
    if (!value && !has_initial) at_origin = id;
    fixed.push_back({PoseIndex(*pose), value.value_or(has_initial ? initial->value : Pose<Dim>{})});
  }
  return fixed_once(std::move(fixed), log_.poses);
}

template class LogBuilder<2>;
template class LogBuilder<3>;

}  // namespace mapjoin
