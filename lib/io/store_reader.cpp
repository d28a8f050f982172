// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <fstream>
#include <mapjoin/io/store.hpp>
#include <mapjoin/io/store_check.hpp>
#include <mapjoin/io/store_records.hpp>
#include <mapjoin/io/store_schema.hpp>
#include <mapjoin/model/map_stretches.hpp>
#include <mapjoin/parallel/parallel_try.hpp>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using store::Database;
using store::Statement;

/// What the header of an SQLite file says of it.
struct Header {
  std::int64_t application_id = 0;
  std::int64_t version = 0;
  bool is_alone = false;  ///< Reading needs no other files beside it.
};

/// Nothing where the file does not begin as an SQLite file does.
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

/// The map in the current row of a SELECT of all columns of `maps`, its information without the lower triangle (see
/// finish_maps()); nothing where the sizes do not agree.
template <int Dim>
std::optional<LocalMap<Dim>> map_of_row(const Statement& row) {
  LocalMap<Dim> map;
  map.base = static_cast<Index>(row.integer(1));
  map.chi2 = row.number(2);
  if (!store::decode_all(row.bytes(3), map.poses) || !store::decode_all(row.bytes(4), map.features) ||
      !store::decode_all(row.bytes(5), map.pose_estimates) || !store::decode_all(row.bytes(6), map.feature_estimates)) {
    return std::nullopt;
  }
  const auto rows = static_cast<Eigen::Index>(kPoseDof<Dim> * map.poses.size() + Dim * map.features.size());
  auto information = store::decode_upper(row.bytes(7), rows);
  if (!information) return std::nullopt;
  map.information = std::move(*information);
  return map;
}

/// Makes each information symmetric and checks each map beside its stretch; the first fault.
template <int Dim>
Expected<void> finish_maps(StoredMaps<Dim>& stored, const std::string& file) {
  const auto stretches = map_stretches(stored.stretches);
  return parallel_try(stored.maps.size(), [&](std::size_t k) {
    Eigen::MatrixXd& information = stored.maps[k].information;
    information.template triangularView<Eigen::StrictlyLower>() = information.transpose();
    return store::check_map(stored.maps[k], *stretches[k], stored.log, file);
  });
}

/// Every stretch that is a map has its row, in order; it becomes a span where that is empty.
template <int Dim>
Expected<void> read_maps(Database& database, const std::string& file, StoredMaps<Dim>& stored) {
  auto select = database.prepare("SELECT * FROM maps ORDER BY stretch");
  if (!select) return tl::unexpected(select.error());
  for (std::size_t i = 0; i < stored.stretches.size(); ++i) {
    Stretch& stretch = stored.stretches[i];
    if (!stretch.is_map) continue;
    const auto row = select->step();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return bad_input(fmt::format("{}: unfinished store: the local map of stretch {} is missing", file, i));
    if (select->integer(0) != static_cast<std::int64_t>(i)) {
      return bad_input(fmt::format("{}: damaged store: its maps are not those of its stretches", file));
    }
    stretch.is_map = !select->is_null(1);
    if (!stretch.is_map) continue;
    auto map = map_of_row<Dim>(*select);
    if (!map) return bad_input(fmt::format("{}: damaged store: the sizes of map {} do not agree", file, i));
    stored.maps.push_back(std::move(*map));
  }
  const auto more = select->step();
  if (!more) return tl::unexpected(more.error());
  if (*more) return bad_input(fmt::format("{}: damaged store: it has more maps than stretches", file));
  return finish_maps(stored, file);
}

template <int Dim>
Expected<AnyStoredMaps> read(Database& database, const std::string& file) {
  auto contents = store::read_contents<Dim>(database, file);
  if (!contents) return tl::unexpected(contents.error());
  StoredMaps<Dim> stored{std::move(contents->log), std::move(contents->stretches), {}, std::move(contents->options)};
  if (auto ok = read_maps(database, file, stored); !ok) return tl::unexpected(ok.error());
  return stored;
}

}  // namespace

bool is_store(const fs::path& path) {
  const auto header = read_header(path);
  return header && header->application_id == store::kApplicationId;
}

Expected<AnyStoredMaps> read_store(const fs::path& path) {
  const std::string file = path.string();
  const auto header = read_header(path);
  if (!header || header->application_id != store::kApplicationId) {
    return bad_input(fmt::format("{}: not a mapjoin store", file));
  }
  if (header->version != store::kVersion) {
    return bad_input(fmt::format("{}: a mapjoin store of version {}; this mapjoin reads version {}", file, header->version,
                                 store::kVersion));
  }
  if (!header->is_alone) return bad_input(fmt::format("{}: damaged store: it asks for a write-ahead log", file));
  auto database = Database::open_read_only(path);
  if (!database) return tl::unexpected(database.error());
  const auto sound = store::check_database(*database, file);
  if (!sound) return tl::unexpected(sound.error());
  const auto dimension = store::stored_dimension(*database, file);
  if (!dimension) return tl::unexpected(dimension.error());
  return *dimension == 2 ? read<2>(*database, file) : read<3>(*database, file);
}

}  // namespace mapjoin
