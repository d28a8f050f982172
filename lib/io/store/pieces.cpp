// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/store/map_rows.hpp>
#include <mapjoin/io/store/pieces.hpp>
#include <utility>

namespace mapjoin {
namespace {

using store::Database;
using store::Statement;

/// The map in a row of `segment`; nothing where none was determined.
template <int Dim>
Expected<std::optional<LocalMap<Dim>>> checked_map(const Database& database, const Statement& row, const Segment& segment,
                                                   const Log<Dim>& log) {
  if (row.is_null(1)) return std::nullopt;
  auto map = store::map_of<Dim>(row);
  if (map && store::is_map_of(*map, segment, log)) return map;
  return database.damaged(fmt::format("the local map of {} to {} makes no sense", to_string(log.poses[segment.begin]),
                                      to_string(log.poses[segment.end])));
}

}  // namespace

Expected<StorePieces> StorePieces::open(const std::filesystem::path& path) {
  return store::open_store(path).map([](Database&& database) { return StorePieces(std::move(database)); });
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
    if (!*found) {
      return bad_input(fmt::format("{}: unfinished store: the local map of segment {} is missing", database_.file(), k));
    }
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
