// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/store/layout.hpp>
#include <mapjoin/io/store/records.hpp>
#include <span>

namespace mapjoin::store {
namespace {

constexpr const char* kTables[] = {
    R"(CREATE TABLE info (key TEXT PRIMARY KEY, value TEXT NOT NULL, crc32 INTEGER NOT NULL) WITHOUT ROWID)",
    R"(CREATE TABLE records (chunk INTEGER PRIMARY KEY, name TEXT NOT NULL, data BLOB NOT NULL, crc32 INTEGER NOT NULL))",
    R"(CREATE TABLE maps (
  segment INTEGER PRIMARY KEY, base INTEGER, chi2 REAL,
  poses BLOB, features BLOB, pose_estimates BLOB, feature_estimates BLOB, information BLOB, crc32 INTEGER NOT NULL))",
};

/// A table, the name of its rows, and the columns that the checksum of a row covers.
struct Checksums {
  const char* table;
  const char* row;
  const char* columns;
};
constexpr Checksums kChecksums[] = {
    {"info", "key", "key, value"},
    {"records", "chunk", "name, data"},
    {"maps", "segment", "segment, base, chi2, poses, features, pose_estimates, feature_estimates, information"},
};
constexpr std::size_t kChunkSize = std::size_t{1} << 20;

/// Hands the arrays to `take` in chunks of whole records, in the order of the file.
template <int Dim, typename Take>
void visit_chunks(const Contents<Dim>& contents, const Take& take) {
  visit_arrays(contents.log, contents.segments, [&](std::string_view name, const auto& records) {
    const std::span all(records);
    const std::size_t per_chunk = std::max<std::size_t>(1, kChunkSize / record_size<typename decltype(all)::value_type>());
    for (std::size_t begin = 0; begin < all.size(); begin += per_chunk) {
      take(name, encode_all(all.subspan(begin, std::min(per_chunk, all.size() - begin))));
    }
  });
}

template <int Dim>
Info info_of(const Contents<Dim>& contents) {
  Info info{{"dimension", std::to_string(Dim)}, {"source", contents.log.source}, {"options", contents.options}};
  for (const auto& [what, count] : contents.log.skipped) info[std::string(kSkipped) + what] = std::to_string(count);
  for (const auto& [name, factor] : kInflatedKinds) {
    const double by = contents.log.conventions.inflation.*factor;
    if (by != 1.0) info[std::string(kInflated) + std::string(name)] = fmt::format("{}", by);
  }
  const auto put = [&](const char* key, const auto& one_of) {
    if (!one_of.is_whole()) info[key] = fmt::format("{}/{}", one_of.index + 1, one_of.count);
  };
  put(kPortion, contents.portion);
  put(kShare, contents.share);
  if (contents.features_are_shared) info[kFeatures] = kSharedFeatures;
  visit_numbers(contents.log, [&]<typename Number>(const char* key, Number number) {
    if constexpr (std::is_enum_v<Number>) {
      info[key] = fmt::format("{}", static_cast<int>(number));
    } else {
      info[key] = fmt::format("{}", number);
    }
  });
  return info;
}

template <int Dim>
std::vector<std::string> arrays_of(const Log<Dim>& log, bool with_factors) {
  std::vector<std::string> arrays;
  visit_arrays(log, std::vector<Segment>(), [&](std::string_view name, const auto& records) {
    if (with_factors || !is_of_factors(name)) arrays.push_back(encode_all(records));
  });
  return arrays;
}

Expected<void> check_integrity(Database& database) {
  std::string found;
  const auto checked = database.rows("PRAGMA quick_check(1)", [&](const Statement& row) {
    found = row.bytes(0);
    return true;
  });
  if (!checked || found == "ok") return checked;
  // The fault stands below a line that names the database.
  return database.damaged(printable(found.substr(found.rfind('\n') + 1)));
}

/// Bad input if a row is not as it was written.
Expected<void> check_checksums(Database& database) {
  for (const auto& [table, row, columns] : kChecksums) {
    std::string found;
    const auto checked =
        database.rows(fmt::format("SELECT {} FROM {} WHERE crc32 IS NOT crc32({}) ORDER BY 1 LIMIT 1", row, table, columns),
                      [&](const Statement& wrong) {
                        found = wrong.bytes(0);
                        return false;
                      });
    if (!checked) return checked;
    if (!found.empty())
      return database.damaged(fmt::format("{} {} of {} is not as it was written", row, printable(found), table));
  }
  return {};
}

}  // namespace

Expected<Info> read_info(Database& database) {
  Info info;
  return database
      .rows("SELECT key, value FROM info",
            [&](const Statement& row) {
              info[std::string(row.bytes(0))] = row.bytes(1);
              return true;
            })
      .map([&] { return info; });
}

Expected<void> check_database(Database& database) {
  const auto sound = check_integrity(database);
  if (!sound) return sound;
  std::vector<std::string> tables;
  const auto read =
      database.rows("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY rowid", [&](const Statement& row) {
        tables.emplace_back(row.bytes(0));
        return true;
      });
  if (!read) return read;
  const bool are_of_store = std::equal(tables.begin(), tables.end(), std::begin(kTables), std::end(kTables));
  return are_of_store ? check_checksums(database) : database.damaged("its tables are not a store's");
}

template <int Dim>
Expected<void> write_contents(Database& database, const Contents<Dim>& contents) {
  std::string sql = fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {};", kApplicationId, kVersion);
  for (const char* table : kTables) sql += std::string(table) + ";";
  Expected<void> result = database.execute(sql);
  const auto insert = [&](std::string_view into, std::string_view first, std::string_view second) {
    if (!result) return;
    result = database.prepare(into).and_then(
        [&](Statement&& statement) { return statement.bind(first).bind(second).step().map([](bool) {}); });
  };
  for (const auto& [key, value] : info_of(contents))
    insert("INSERT INTO info VALUES (CAST(?1 AS TEXT), CAST(?2 AS TEXT), crc32(CAST(?1 AS TEXT), CAST(?2 AS TEXT)))", key,
           value);
  visit_chunks(contents, [&](std::string_view name, const std::string& bytes) {
    insert("INSERT INTO records (name, data, crc32) VALUES (CAST(?1 AS TEXT), ?2, crc32(CAST(?1 AS TEXT), ?2))", name, bytes);
  });
  return result;
}

template <int Dim>
Expected<bool> holds_contents(Database& database, const Contents<Dim>& contents) {
  const auto info = read_info(database);
  if (!info) return tl::unexpected(info.error());
  auto select = database.prepare("SELECT name, data FROM records ORDER BY chunk");
  if (!select) return tl::unexpected(select.error());
  Expected<bool> more = true;
  bool same = *info == info_of(contents);
  visit_chunks(contents, [&](std::string_view name, const std::string& bytes) {
    if (!same || !more) return;
    more = select->step();
    same = more && *more && select->bytes(0) == name && select->bytes(1) == bytes;
  });
  if (!more || !same) return more.map([](bool) { return false; });
  return select->step().map([](bool is_longer) { return !is_longer; });
}

template <int Dim>
bool is_same_log(const Log<Dim>& a, const Log<Dim>& b) {
  return arrays_of(a, true) == arrays_of(b, true);
}

template <int Dim>
bool is_same_but_for_factors(const Log<Dim>& a, const Log<Dim>& b) {
  return arrays_of(a, false) == arrays_of(b, false);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                \
  template Expected<void> write_contents<Dim>(Database&, const Contents<Dim>&); \
  template Expected<bool> holds_contents<Dim>(Database&, const Contents<Dim>&); \
  template bool is_same_log<Dim>(const Log<Dim>&, const Log<Dim>&);             \
  template bool is_same_but_for_factors<Dim>(const Log<Dim>&, const Log<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::store
