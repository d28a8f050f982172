// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <fstream>
#include <mapjoin/io/store/map_rows.hpp>
#include <mapjoin/io/store/store.hpp>
#include <mapjoin/parallel/pieces.hpp>
#include <utility>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using store::Database;
using store::Statement;

/// The header of an SQLite file.
struct Header {
  std::int64_t application_id = 0;
  std::int64_t version = 0;
  bool is_alone = false;  ///< True if reading needs no other files beside it.
};

/// The header of a file; nullopt if it does not begin as an SQLite file does.
std::optional<Header> read_header(const fs::path& path) {
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  std::array<char, 100> bytes{};
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  if (!file.read(bytes.data(), bytes.size()) || std::string_view(bytes.data(), kMagic.size()) != kMagic) return std::nullopt;
  const auto big_endian = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    return std::int64_t{value};
  };
  constexpr char kRollback = 1;  // Not a write-ahead log.
  return Header{big_endian(68), big_endian(60), bytes[18] == kRollback && bytes[19] == kRollback};
}

/// Reads the map of every segment that is a map; a segment whose map was not determined becomes a raw segment.
template <int Dim>
Expected<void> read_maps(Database& database, StoredMaps<Dim>& stored) {
  std::vector<std::size_t> of_segment;  ///< Segment of each map.
  std::string fault;
  std::size_t next = 0;
  const auto skip_spans = [&] {
    while (next < stored.segments.size() && !stored.segments[next].is_map) ++next;
  };
  skip_spans();
  const auto read = database.rows("SELECT * FROM maps ORDER BY segment", [&](const Statement& row) {
    if (next >= stored.segments.size() || row.integer(0) != static_cast<std::int64_t>(next)) {
      fault = "its maps are not those of its segments";
    } else if (row.is_null(1)) {
      stored.segments[next].is_map = false;
    } else if (auto map = store::map_of<Dim>(row)) {
      stored.maps.push_back(std::move(*map));
      of_segment.push_back(next);
    } else {
      fault = fmt::format("the sizes of map {} do not agree", next);
    }
    ++next;
    skip_spans();
    return fault.empty();
  });
  if (!read) return read;
  if (!fault.empty()) return database.damaged(fault);
  if (next < stored.segments.size()) return database.unfinished(next);
  return parallel_try(stored.maps.size(), [&](std::size_t m) -> Expected<void> {
    const Segment& segment = stored.segments[of_segment[m]];
    if (store::is_map_of(stored.maps[m], segment, indices(stored.log.features))) return {};
    const auto name = [&](PoseIndex pose) { return to_string(stored.log.poses[pose]); };
    return database.damaged(fmt::format("the local map of {} to {} makes no sense", name(segment.begin), name(segment.end)));
  });
}

template <int Dim>
Expected<AnyStoredMaps> read(Database& database) {
  return store::read_contents<Dim>(database).and_then([&](StoredMaps<Dim>&& stored) -> Expected<AnyStoredMaps> {
    if (auto maps = read_maps(database, stored); !maps) return tl::unexpected(maps.error());
    return std::move(stored);
  });
}

}  // namespace

bool is_store(const fs::path& path) {
  const auto header = read_header(path);
  return header && header->application_id == store::kApplicationId;
}

Expected<Database> store::open_store(const fs::path& path) {
  const std::string file = path.string();
  const auto header = read_header(path);
  if (!header || header->application_id != store::kApplicationId) {
    return bad_input(fmt::format("{}: not a mapjoin store", file));
  }
  if (header->version != store::kVersion) {
    return bad_input(fmt::format("{}: a mapjoin store of version {}; this mapjoin reads version {}: build it again", file,
                                 header->version, store::kVersion));
  }
  if (!header->is_alone)
    return bad_input(fmt::format("{}: damaged store: it asks for a write-ahead log; build it again", file));
  return Database::open_read_only(path);
}

Expected<AnyStoredMaps> read_store(const fs::path& path) {
  auto database = store::open_store(path);
  if (!database) return tl::unexpected(database.error());
  return store::check_database(*database)
      .and_then([&] { return store::stored_dimension(*database); })
      .and_then([&](int dimension) { return dimension == 2 ? read<2>(*database) : read<3>(*database); });
}

template <int Dim>
bool has_maps_alone(const StoredMaps<Dim>& stored) {
  const Log<Dim>& log = stored.log;
  return !stored.maps.empty() && log.graph.pose_factors.empty() && log.graph.feature_factors.empty();
}

template <int Dim>
SubmapSet<Dim> submap_set_of(StoredMaps<Dim> stored, const fs::path& path) {
  SubmapSet<Dim> set;
  set.source = path.string();
  set.poses = std::move(stored.log.poses);
  set.features = std::move(stored.log.features);
  set.graph.submaps = std::move(stored.maps);
  set.graph.fixed = std::move(stored.log.graph.fixed);
  set.segments = std::move(stored.segments);
  set.conventions = stored.log.conventions;
  set.features_are_shared = stored.features_are_shared;
  return set;
}

template bool has_maps_alone(const StoredMaps<2>&);
template bool has_maps_alone(const StoredMaps<3>&);
template SubmapSet<2> submap_set_of(StoredMaps<2>, const fs::path&);
template SubmapSet<3> submap_set_of(StoredMaps<3>, const fs::path&);

}  // namespace mapjoin
