// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <limits>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/store/layout.hpp>
#include <mapjoin/io/store/records.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace mapjoin::store {
namespace {

/// Takes the portion or share, "2/4", under `key` in `info`, the whole if there is none; false if it makes no sense.
template <typename OneOf>
bool take_one_of(const Info& info, const char* key, OneOf& one_of) {
  const auto found = info.find(key);
  if (found == info.end()) return true;
  std::istringstream text(found->second);
  std::size_t number = 0;
  std::size_t count = 0;
  char slash = 0;
  const bool is_read = static_cast<bool>(text >> number >> slash >> count) && text.eof();
  if (!is_read || slash != '/' || number < 1 || number > count || count < 2) return false;
  one_of = {number - 1, count};
  return true;
}

/// Takes the number under `key` in `info`, which is not negative, and 0 or 1 for an enumeration; false if it is missing or
/// makes no sense.
template <typename Number>
bool take_number(const Info& info, const std::string& key, Number& number) {
  const auto found = info.find(key);
  if (found == info.end()) return false;
  const std::string& text = found->second;
  std::conditional_t<std::is_enum_v<Number>, int, Number> value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const auto most = std::is_enum_v<Number> ? 1.0 : std::numeric_limits<double>::max();
  const auto size = static_cast<double>(value);
  if (error != std::errc() || end != text.data() + text.size() || !(0.0 <= size && size <= most)) return false;
  number = static_cast<Number>(value);
  return true;
}

/// The log that LogBuilder makes of these arrays. Throws std::out_of_range if one refers to a pose or feature that is missing.
template <int Dim>
Expected<Log<Dim>> built_anew(const Log<Dim>& log) {
  LogBuilder<Dim> builder("", without_repairs(log.conventions));
  builder.append(log);
  return std::move(builder).finish(log.poses);
}

/// The log built anew; nullopt if its arrays do not fit together.
template <int Dim>
std::optional<Expected<Log<Dim>>> built_if_sound(const Log<Dim>& log) {
  const auto fits = [](const auto& values, const auto& names) { return values.size() <= names.size(); };
  if (!fits(log.initial.poses, log.poses) || !fits(log.initial.features, log.features)) return std::nullopt;
  try {
    return built_anew(log);
  } catch (const std::out_of_range&) {
    return std::nullopt;
  }
}

template <int Dim>
bool are_in_order(const std::vector<Segment>& segments, const Log<Dim>& log) {
  PoseIndex begin = 0;
  for (const Segment& segment : segments) {
    if (segment.begin < begin || segment.end < segment.begin || !indices(log.poses).contains(segment.end)) return false;
    begin = segment.end;
  }
  return true;
}

/// The arrays in these rows as they stand, with the numbers and texts in `info`.
template <int Dim>
Expected<StoredMaps<Dim>> read_arrays(Database& database, std::string_view rows) {
  auto info = read_info(database);
  if (!info) return tl::unexpected(info.error());
  StoredMaps<Dim> stored;
  std::string fault;
  if (!take_one_of(*info, kPortion, stored.portion)) fault = "info portion makes no sense";
  if (!take_one_of(*info, kShare, stored.share)) fault = "info part makes no sense";
  if (const auto features = info->find(kFeatures); features != info->end()) {
    stored.features_are_shared = features->second == kSharedFeatures;
    if (!stored.features_are_shared) fault = "info features makes no sense";
  }
  visit_numbers(stored.log, [&](const char* key, auto& number) {
    if (!take_number(*info, key, number)) fault = fmt::format("info {} is missing or makes no sense", key);
  });
  for (const auto& [key, count] : *info) {
    if (!key.starts_with(kSkipped)) continue;
    if (!take_number(*info, key, stored.log.skipped[key.substr(kSkipped.size())]))
      fault = "info " + printable(key) + " makes no sense";
  }
  for (const auto& [name, factor] : kInflatedKinds) {
    const std::string key = std::string(kInflated) + std::string(name);
    if (info->contains(key) && !take_number(*info, key, stored.log.conventions.inflation.*factor)) {
      fault = "info " + key + " makes no sense";
    }
  }
  const auto read = database.rows(rows, [&](const Statement& row) {
    bool is_taken = false;
    visit_arrays(stored.log, stored.segments, [&](std::string_view name, auto& records) {
      if (name == row.bytes(0)) is_taken = decode_all(row.bytes(1), records);
    });
    if (!is_taken) fault = printable(row.bytes(0)) + " is no array, or has part of a record";
    return is_taken;
  });
  if (!read) return tl::unexpected(read.error());
  if (!fault.empty()) return database.damaged(fault);
  stored.log.source = (*info)["source"];
  stored.options = (*info)["options"];
  return stored;
}

}  // namespace

Expected<int> stored_dimension(Database& database) {
  const auto info = read_info(database);
  if (!info) return tl::unexpected(info.error());
  int dimension = 0;
  if (take_number(*info, "dimension", dimension) && (dimension == 2 || dimension == 3)) return dimension;
  return database.damaged("its dimension is neither 2 nor 3");
}

template <int Dim>
Expected<StoredMaps<Dim>> read_contents(Database& database) {
  auto stored = read_arrays<Dim>(database, "SELECT name, data FROM records ORDER BY chunk");
  if (!stored) return stored;
  auto built = built_if_sound(stored->log);
  if (!built) return database.damaged("its arrays do not hang together");
  Expected<Log<Dim>>& log = *built;
  if (!log) return database.damaged(log.error().message);
  if (log->features != stored->log.features) return database.damaged("its features are not in order");
  if (!are_in_order(stored->segments, *log)) return database.damaged("its segments are not in order");
  log->source = std::move(stored->log.source);
  stored->log = *std::move(log);
  return stored;
}

template <int Dim>
Expected<StoredMaps<Dim>> read_outline(Database& database) {
  auto stored = read_arrays<Dim>(
      database, "SELECT name, data FROM records WHERE name IN ('poses', 'features', 'fixed', 'segments') ORDER BY chunk");
  if (!stored) return stored;
  const Log<Dim>& log = stored->log;
  auto names = log.poses;
  std::ranges::sort(names);
  const bool are_once = !names.empty() && std::ranges::adjacent_find(names) == names.end();
  const bool is_ascending = std::ranges::adjacent_find(log.features, std::greater_equal<>()) == log.features.end();
  if (!are_once || !is_ascending) return database.damaged("its poses or features are not in order");
  const bool are_fixed = std::ranges::all_of(log.graph.fixed, [&](const FixedPose<Dim>& fixed) {
    return indices(log.poses).contains(fixed.pose) && is_valid(fixed.value);
  });
  if (!are_fixed) return database.damaged("its arrays do not hang together");
  if (!are_in_order(stored->segments, log)) return database.damaged("its segments are not in order");
  return stored;
}

template <int Dim>
Expected<void> read_factors(Database& database, std::span<const std::int64_t> chunks, FactorGraph<Dim>& graph) {
  auto select = database.prepare("SELECT name, data FROM records WHERE chunk = ?");
  if (!select) return tl::unexpected(select.error());
  for (const std::int64_t chunk : chunks) {
    const auto found = select->bind(chunk).step();
    if (!found) return tl::unexpected(found.error());
    const bool is_pose = *found && select->bytes(0) == "pose_factors";
    const bool is_taken = *found && (is_pose ? decode_all(select->bytes(1), graph.pose_factors)
                                             : decode_all(select->bytes(1), graph.feature_factors));
    if (!is_taken) return database.damaged("an array is missing, or has part of a record");
    if (const auto end = select->step(); !end) return tl::unexpected(end.error());
  }
  return {};
}

#define MAPJOIN_INSTANTIATE(Dim)                                    \
  template Expected<StoredMaps<Dim>> read_contents<Dim>(Database&); \
  template Expected<StoredMaps<Dim>> read_outline<Dim>(Database&);  \
  template Expected<void> read_factors(Database&, std::span<const std::int64_t>, FactorGraph<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::store
