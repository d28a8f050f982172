// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <fstream>
#include <mapjoin/io/store.hpp>
#include <mapjoin/io/store_maps.hpp>
#include <mapjoin/io/store_schema.hpp>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using store::Database;

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

template <int Dim>
Expected<AnyStoredMaps> read(Database& database, const std::string& file) {
  auto contents = store::read_contents<Dim>(database, file);
  if (!contents) return tl::unexpected(contents.error());
  StoredMaps<Dim> stored{std::move(contents->log), std::move(contents->stretches), {}, std::move(contents->options)};
  if (auto ok = store::read_maps(database, file, stored); !ok) return tl::unexpected(ok.error());
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
