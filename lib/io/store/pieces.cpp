// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/store/map_rows.hpp>
#include <mapjoin/io/store/pieces.hpp>
#include <utility>

namespace mapjoin {
namespace {

using store::Database;
using store::Statement;

/// The map in a row of `segment`; nullopt if none was determined. Bad input if it makes no sense.
template <int Dim>
Expected<std::optional<LocalMap<Dim>>> checked_map(const Database& database, const Statement& row, const Segment& segment,
                                                   const Log<Dim>& log) {
  if (row.is_null(1)) return std::nullopt;
  auto map = store::map_of<Dim>(row);
  if (map && store::is_map_of(*map, segment, indices(log.features))) return map;
  return database.damaged(fmt::format("the local map of {} to {} makes no sense", to_string(log.poses[segment.begin]),
                                      to_string(log.poses[segment.end])));
}

}  // namespace

Expected<StorePieces> StorePieces::open(const std::filesystem::path& path) {
  return store::open_store(path).map([](Database&& database) { return StorePieces(std::move(database)); });
}

Expected<bool> StorePieces::has_log_of(StorePieces& other, bool with_factors) {
  const std::string rows = fmt::format("SELECT name, data FROM records WHERE name <> 'segments'{} ORDER BY chunk",
                                       with_factors ? "" : " AND name NOT IN ('pose_factors', 'feature_factors')");
  auto theirs = other.database_.prepare(rows);
  if (!theirs) return tl::unexpected(theirs.error());
  Expected<bool> is_same = true;
  const auto read = database_.rows(rows, [&](const Statement& row) {
    is_same = theirs->step().map(
        [&](bool is_there) { return is_there && theirs->bytes(0) == row.bytes(0) && theirs->bytes(1) == row.bytes(1); });
    return is_same && *is_same;
  });
  if (!read) return tl::unexpected(read.error());
  if (!is_same || !*is_same) return is_same;
  return theirs->step().map([](bool is_longer) { return !is_longer; });
}

Expected<std::vector<std::int64_t>> StorePieces::factor_chunks() {
  std::vector<std::int64_t> chunks;
  return database_
      .rows("SELECT chunk FROM records WHERE name IN ('pose_factors', 'feature_factors') ORDER BY chunk",
            [&](const Statement& row) {
              chunks.push_back(row.integer(0));
              return true;
            })
      .map([&] { return chunks; });
}

template <int Dim>
Expected<bool> StorePieces::holds(const store::Contents<Dim>& contents) {
  return store::holds_contents(database_, contents);
}

template <int Dim>
Expected<std::vector<std::optional<LocalMap<Dim>>>> StorePieces::maps(const Log<Dim>& log,
                                                                      const std::vector<Segment>& segments) {
  std::vector<std::optional<LocalMap<Dim>>> maps;
  auto select = database_.prepare("SELECT * FROM maps WHERE segment = ?");
  if (!select) return tl::unexpected(select.error());
  for (std::size_t k = 0; k < segments.size(); ++k) {
    if (!segments[k].is_map) continue;
    const auto found = select->bind(static_cast<std::int64_t>(k)).step();
    if (!found) return tl::unexpected(found.error());
    if (!*found) return database_.unfinished(k);
    auto map = checked_map(database_, *select, segments[k], log);
    if (!map) return tl::unexpected(map.error());
    maps.push_back(*std::move(map));
    if (const auto end = select->step(); !end) return tl::unexpected(end.error());
  }
  return maps;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                       \
  template Expected<bool> StorePieces::holds<Dim>(const store::Contents<Dim>&);                        \
  template Expected<std::vector<std::optional<LocalMap<Dim>>>> StorePieces::maps<Dim>(const Log<Dim>&, \
                                                                                      const std::vector<Segment>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
