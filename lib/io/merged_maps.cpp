// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/io/open.hpp>
#include <mapjoin/io/store/contents.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/model/renumber.hpp>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

/// The indices of one part's poses and features in the whole: poses in their order, features by their names.
struct Renumbering {
  PoseIndex first_pose = 0;
  Table<FeatureIndex, FeatureIndex> features;

  PoseIndex operator()(PoseIndex pose) const { return first_pose + pose.value; }
  FeatureIndex operator()(FeatureIndex feature) const { return features[feature]; }
  Segment operator()(const Segment& segment) const { return {(*this)(segment.begin), (*this)(segment.end), segment.is_map}; }
  template <int Dim>
  LocalMap<Dim> operator()(LocalMap<Dim> map) const {
    renumber(map, *this);
    return map;
  }
};

Renumbering renumbering(PoseIndex first_pose, const FeatureIds& part, const FeatureIds& whole) {
  Renumbering numbers{first_pose, {}};
  for (const FeatureId& id : part) numbers.features.emplace_back(*find_ascending(whole, id));
  return numbers;
}

/// The first pose of every log in the merged one; nullopt if its poses are not in the order of their own log.
template <int Dim>
std::optional<std::vector<PoseIndex>> begins_of(const std::vector<StoredMaps<Dim>>& stores, const PoseIds& merged) {
  std::vector<PoseIndex> begins;
  std::size_t next = 0;
  for (const StoredMaps<Dim>& store : stores) {
    begins.emplace_back(next);
    for (const PoseId& id : store.log.poses) {
      if (merged[PoseIndex(next++)].key != id.key) return std::nullopt;
    }
  }
  return begins;
}

/// Adds the maps of another part of the same build.
template <int Dim>
Expected<void> add_part(StoredMaps<Dim>& whole, StoredMaps<Dim> part) {
  if (auto alike = check_cut_alike(whole.segments, part.segments, whole.log.source); !alike) return alike;
  whole.share = {};
  whole.features_are_shared |= part.features_are_shared;
  std::vector<LocalMap<Dim>> maps;
  auto known = whole.maps.begin();
  auto added = part.maps.begin();
  for (std::size_t k = 0; k < whole.segments.size(); ++k) {
    const bool is_known = std::exchange(whole.segments[k].is_map, whole.segments[k].is_map || part.segments[k].is_map);
    if (whole.segments[k].is_map) maps.push_back(std::move(is_known ? *known : *added));
    known += is_known;
    added += part.segments[k].is_map;
  }
  whole.maps = std::move(maps);
  return {};
}

/// Adds another portion of the same log, with its maps.
template <int Dim>
Expected<void> add_portion(StoredMaps<Dim>& whole, StoredMaps<Dim> portion) {
  append(whole.log.graph.pose_factors, portion.log.graph.pose_factors);
  append(whole.log.graph.feature_factors, portion.log.graph.feature_factors);
  portion.log.graph = {};
  return add_part(whole, std::move(portion));
}

/// The log of all its portions; bad input unless all are there.
template <int Dim>
Expected<StoredMaps<Dim>> completed(std::vector<StoredMaps<Dim>> portions) {
  std::vector<Portion> of;
  for (const StoredMaps<Dim>& portion : portions) of.push_back(portion.portion);
  if (auto complete = check_complete(std::move(of), portions.front().log.source); !complete) {
    return tl::unexpected(complete.error());
  }
  std::ranges::sort(portions, {}, [](const StoredMaps<Dim>& p) { return p.portion.index; });
  StoredMaps<Dim> whole = std::move(portions.front());
  whole.portion = {};
  for (std::size_t k = 1; k < portions.size(); ++k) {
    if (auto added = add_portion(whole, std::move(portions[k])); !added) return tl::unexpected(added.error());
  }
  put_in_order(whole.log);
  return whole;
}

/// Stores of whole logs; portions of one log are put together.
template <int Dim>
Expected<std::vector<StoredMaps<Dim>>> whole_logs(std::vector<StoredMaps<Dim>> stores) {
  std::vector<std::vector<StoredMaps<Dim>>> groups;
  for (StoredMaps<Dim>& next : stores) {
    const auto same = std::ranges::find_if(groups, [&](const auto& group) {
      const StoredMaps<Dim>& known = group.front();
      return !next.portion.is_whole() && known.portion.count == next.portion.count && known.options == next.options &&
             store::is_same_but_for_factors(known.log, next.log);
    });
    (same == groups.end() ? groups.emplace_back() : *same).push_back(std::move(next));
  }
  std::vector<StoredMaps<Dim>> logs;
  for (auto& group : groups) {
    Expected<StoredMaps<Dim>> whole = group.front().portion.is_whole() ? std::move(group.front()) : completed(std::move(group));
    if (!whole) return tl::unexpected(whole.error());
    logs.push_back(*std::move(whole));
  }
  return logs;
}

/// The stores by log.
template <int Dim>
std::vector<std::vector<std::size_t>> stores_by_log(const std::vector<StoredMaps<Dim>>& stores) {
  std::vector<std::vector<std::size_t>> logs;
  for (std::size_t k = 0; k < stores.size(); ++k) {
    const auto same = std::ranges::find_if(
        logs, [&](const auto& known) { return store::is_same_log(stores[known.front()].log, stores[k].log); });
    (same == logs.end() ? logs.emplace_back() : *same).push_back(k);
  }
  return logs;
}

/// Bad input if there are some of the shares of one log, not all, and stores of another: stores of one log that was built in
/// two ways would be taken for two robots.
template <int Dim>
Expected<void> check_shares(const std::vector<StoredMaps<Dim>>& stores, const std::vector<std::filesystem::path>& paths) {
  const auto is_whole = [](const StoredMaps<Dim>& store) { return store.share.is_whole(); };
  if (std::ranges::all_of(stores, is_whole)) return {};
  const auto logs = stores_by_log(stores);
  const auto has_all = [&](const std::vector<std::size_t>& log) {
    Share next{0, stores[log.front()].share.count};
    const auto is_next = [&](std::size_t k) { return stores[k].share == next; };
    while (next.index < next.count && std::ranges::any_of(log, is_next)) ++next.index;
    return next.index == next.count || std::ranges::any_of(log, [&](std::size_t k) { return is_whole(stores[k]); });
  };
  const auto some = std::ranges::find_if_not(logs, has_all);
  if (logs.size() < 2 || some == logs.end()) return {};
  const std::size_t one = logs.front().front();
  const std::size_t other = (some == logs.begin() ? logs[1] : *some).front();
  const auto part = [&](std::size_t k) { return fmt::format("{}/{}", stores[k].share.index + 1, stores[k].share.count); };
  return bad_input(
      fmt::format("{} and {} have parts {} and {} of the local maps of different logs, or of one log read with other "
                  "options: build all parts from the same log with the same options, or give all parts of each log",
                  paths[one].string(), paths[other].string(), part(one), part(other)));
}

/// One store of each log; several stores of one log are parts of one build.
template <int Dim>
Expected<std::vector<StoredMaps<Dim>>> united(std::vector<StoredMaps<Dim>> stores) {
  std::vector<StoredMaps<Dim>> logs;
  for (StoredMaps<Dim>& next : stores) {
    const auto same =
        std::ranges::find_if(logs, [&](const StoredMaps<Dim>& known) { return store::is_same_log(known.log, next.log); });
    const auto added = same == logs.end() ? Expected<void>() : add_part(*same, std::move(next));
    if (!added) return tl::unexpected(added.error());
    if (same == logs.end()) logs.push_back(std::move(next));
  }
  return logs;
}

/// The maps of different logs, each log a session.
template <int Dim>
Expected<AnyMaps> merged_sessions(std::vector<StoredMaps<Dim>> stores, const MergeOptions& options) {
  std::vector<Log<Dim>> logs;
  for (const StoredMaps<Dim>& store : stores) logs.push_back(store.log);
  if (auto once = options.keep_copies ? Expected<void>() : check_no_copies(logs); !once) {
    return tl::unexpected(once.error());
  }
  if (auto apart = options.own_features ? number_features_apart(logs) : Expected<void>(); !apart) {
    return tl::unexpected(apart.error());
  }
  for (std::size_t k = 0; k < stores.size(); ++k) stores[k].log.features = logs[k].features;
  auto log = merged(std::move(logs), {.keep_copies = options.keep_copies});
  if (!log) return tl::unexpected(log.error());
  const auto begins = begins_of(stores, log->poses);
  if (!begins)
    return bad_input(log->source + ": the order of their poses changes with each other's: build one store of both logs");
  std::vector<Renumbering> parts;
  for (std::size_t k = 0; k < stores.size(); ++k) {
    parts.push_back(renumbering((*begins)[k], stores[k].log.features, log->features));
  }
  StoredMaps<Dim> whole{*std::move(log), {}, {}, stores.front().options};
  for (std::size_t k = 0; k < stores.size(); ++k) {
    auto map = stores[k].maps.begin();
    for (const Segment& segment : stores[k].segments) {
      whole.segments.push_back(parts[k](segment));
      if (segment.is_map) whole.maps.push_back(parts[k](std::move(*map++)));
    }
  }
  return AnyMaps(std::move(whole));
}

template <int Dim>
Expected<AnyMaps> merged_maps(std::vector<StoredMaps<Dim>> stores, const std::vector<std::filesystem::path>& paths,
                              const MergeOptions& options) {
  return check_shares(stores, paths)
      .and_then([&] { return whole_logs(std::move(stores)); })
      .and_then([](std::vector<StoredMaps<Dim>> logs) { return united(std::move(logs)); })
      .and_then([&](std::vector<StoredMaps<Dim>> logs) -> Expected<AnyMaps> {
        if (logs.size() == 1) return AnyMaps(std::move(logs.front()));
        return merged_sessions(std::move(logs), options);
      });
}

template <int Dim>
Expected<AnyMaps> merged_maps(std::vector<SubmapSet<Dim>> sets, const Conventions& conventions, const MergeOptions& options) {
  if (auto once = options.keep_copies ? Expected<void>() : check_no_copies(sets); !once) {
    return tl::unexpected(once.error());
  }
  if (auto apart = options.own_features ? number_features_apart(sets) : Expected<void>(); !apart) {
    return tl::unexpected(apart.error());
  }
  SubmapSet<Dim> whole;
  whole.conventions = conventions;
  for (const SubmapSet<Dim>& set : sets) {
    whole.source += (whole.source.empty() ? "" : " + ") + set.source;
    append(whole.features, set.features);
  }
  make_distinct(whole.features);
  const auto first_session = first_sessions(sets);
  if (!first_session) return tl::unexpected(first_session.error());
  for (std::size_t k = 0; k < sets.size(); ++k) {
    const Renumbering part = renumbering(PoseIndex(whole.poses.size()), sets[k].features, whole.features);
    for (const PoseId& id : sets[k].poses) whole.poses.push_back({(*first_session)[k] + id.session, id.key});
    for (const Segment& segment : sets[k].segments) whole.segments.push_back(part(segment));
    for (LocalMap<Dim>& map : sets[k].graph.submaps) whole.graph.submaps.push_back(part(std::move(map)));
  }
  return AnyMaps(std::move(whole));
}

/// The conventions of all maps together; bad input if some have other weights than others.
Expected<Conventions> conventions_of(const std::vector<AnyMaps>& all, const std::vector<std::filesystem::path>& paths) {
  const auto conventions = [](const auto& maps) {
    if constexpr (requires { maps.log; })
      return maps.log.conventions;
    else
      return maps.conventions;
  };
  std::vector<NamedConventions> named;
  for (std::size_t k = 0; k < all.size(); ++k) named.push_back({paths[k].string(), std::visit(conventions, all[k])});
  return common_conventions(named);
}

/// All maps as one type; nullopt if one is of another type.
template <typename Maps>
std::optional<std::vector<Maps>> all_as(std::vector<AnyMaps>& any) {
  std::vector<Maps> same;
  for (AnyMaps& one : any) {
    auto* maps = std::get_if<Maps>(&one);
    if (!maps) return std::nullopt;
    same.push_back(std::move(*maps));
  }
  return same;
}

}  // namespace

Expected<AnyMaps> open_several_maps(const std::vector<std::filesystem::path>& paths, const ReadOptions& options,
                                    const MergeOptions& merging) {
  if (paths.empty()) return tl::unexpected(Error{ErrorKind::kUsage, "no local maps are named"});
  if (paths.size() == 1) return open_maps(paths.front(), options);
  std::vector<AnyMaps> all;
  for (const std::filesystem::path& path : paths) {
    auto maps = open_maps_or_portion(path, options);
    if (!maps) return maps;
    all.push_back(*std::move(maps));
    if (all.back().index() == all.front().index()) continue;
    return bad_input(
        fmt::format("{} and {} are not of one kind and dimension: stores that `mapjoin build` made of logs, or the "
                    "maps of others",
                    paths.front().string(), path.string()));
  }
  const auto conventions = conventions_of(all, paths);
  if (!conventions) return tl::unexpected(conventions.error());
  const auto merge_like = [&]<typename Maps>(const Maps&) {
    if constexpr (requires(Maps maps) { maps.log; })
      return merged_maps(*all_as<Maps>(all), paths, merging);
    else
      return merged_maps(*all_as<Maps>(all), *conventions, merging);
  };
  return std::visit(merge_like, AnyMaps(all.front()));
}

}  // namespace mapjoin
