// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/store/contents.hpp>
#include <mapjoin/io/store/records.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <sstream>
#include <stdexcept>

namespace mapjoin::store {
namespace {

constexpr const char* kTables[] = {
    R"(CREATE TABLE info (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID)",
    R"(CREATE TABLE records (chunk INTEGER PRIMARY KEY, name TEXT NOT NULL, data BLOB NOT NULL))",
    R"(CREATE TABLE maps (
  segment INTEGER PRIMARY KEY, base INTEGER, chi2 REAL,
  poses BLOB, features BLOB, pose_estimates BLOB, feature_estimates BLOB, information BLOB))",
};
constexpr std::size_t kChunkSize = std::size_t{1} << 20;

/// Hands every array to `visit`, with its name in the file.
template <typename Log, typename Segments, typename Visit>
void visit_arrays(Log& log, Segments&& segments, const Visit& visit) {
  visit("poses", log.poses);
  visit("features", log.features);
  visit("pose_factors", log.graph.pose_factors);
  visit("feature_factors", log.graph.feature_factors);
  visit("fixed", log.graph.fixed);
  visit("stamps_ns", log.stamps_ns);
  visit("initial_poses", log.initial.poses);
  visit("initial_features", log.initial.features);
  visit("segments", segments);
}

/// Hands every number that stands alone to `visit`, with its name in the file.
template <typename Log, typename Visit>
void visit_numbers(Log& log, const Visit& visit) {
  visit("unassociated", log.unassociated);
  visit("pose_error", log.conventions.pose_error);
  visit("rotation_information", log.conventions.rotation_information);
  visit("covariance", log.conventions.covariance);
  visit("repaired_informations", log.conventions.repairs.indefinite);
  visit("symmetrised_matrices", log.conventions.repairs.symmetrised);
  visit("largest_asymmetry", log.conventions.repairs.largest_asymmetry);
}

/// The arrays in chunks of whole records, in the order in which they stand in the file.
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

using Info = std::map<std::string, std::string>;

/// Where it stands in `info`, "2/4", if a store has not all factors of its log.
constexpr const char* kPortion = "portion";

template <int Dim>
Info info_of(const Contents<Dim>& contents) {
  Info info{{"dimension", std::to_string(Dim)}, {"source", contents.log.source}, {"options", contents.options}};
  const Portion& portion = contents.portion;
  if (!portion.is_whole()) info[kPortion] = fmt::format("{}/{}", portion.index + 1, portion.count);
  visit_numbers(contents.log, [&]<typename Number>(const char* key, Number number) {
    if constexpr (std::is_enum_v<Number>) {
      info[key] = fmt::format("{}", static_cast<int>(number));
    } else {
      info[key] = fmt::format("{}", number);
    }
  });
  return info;
}

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

/// Nothing where what `info` says is no portion.
std::optional<Portion> portion_of(const Info& info) {
  const auto found = info.find(kPortion);
  if (found == info.end()) return Portion{};
  std::istringstream text(found->second);
  std::size_t number = 0;
  std::size_t count = 0;
  char slash = 0;
  const bool is_read = static_cast<bool>(text >> number >> slash >> count) && text.eof();
  if (!is_read || slash != '/' || number < 1 || number > count || count < 2) return std::nullopt;
  return Portion{number - 1, count};
}

/// The number that `info` has under `key`; an enumeration's is 0 or 1. False where there is none.
template <typename Number>
bool take_number(const Info& info, const char* key, Number& number) {
  const auto found = info.find(key);
  if (found == info.end()) return false;
  const std::string& text = found->second;
  std::conditional_t<std::is_floating_point_v<Number>, double, std::int64_t> value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= 0)) return false;
  if (std::is_enum_v<Number> && value > 1) return false;
  number = static_cast<Number>(value);
  return true;
}

/// The log that LogBuilder makes of these arrays; std::out_of_range where one names what is not there.
template <int Dim>
Expected<Log<Dim>> built_anew(const Log<Dim>& log, const std::string& source, PoseOrder order) {
  LogBuilder<Dim> builder(source, log.conventions);
  builder.append(log);
  return std::move(builder).finish(order);
}

/// Nothing where its arrays do not hang together.
template <int Dim>
std::optional<Expected<Log<Dim>>> built_if_sound(const Log<Dim>& log, const std::string& source, PoseOrder order) {
  const auto fits = [](const auto& values, const auto& names) { return values.size() <= names.size(); };
  if (!fits(log.initial.poses, log.poses) || !fits(log.initial.features, log.features)) return std::nullopt;
  try {
    return built_anew(log, source, order);
  } catch (const std::out_of_range&) {
    return std::nullopt;
  }
}

bool is_of_factors(std::string_view array) {
  return array == "pose_factors" || array == "feature_factors";
}

template <int Dim>
std::vector<std::string> arrays_of(const Log<Dim>& log, bool with_factors) {
  std::vector<std::string> arrays;
  visit_arrays(log, std::vector<Segment>(), [&](std::string_view name, const auto& records) {
    if (with_factors || !is_of_factors(name)) arrays.push_back(encode_all(records));
  });
  return arrays;
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

Expected<void> check_integrity(Database& database) {
  std::string found;
  const auto checked = database.rows("PRAGMA quick_check(1)", [&](const Statement& row) {
    found = row.bytes(0);
    return true;
  });
  if (!checked || found == "ok") return checked;
  // What is wrong stands below a line that names the database.
  return database.damaged(printable(found.substr(found.rfind('\n') + 1)));
}

}  // namespace

Expected<void> check_database(Database& database) {
  const auto sound = check_integrity(database);
  if (!sound) return sound;
  std::vector<std::string> tables;
  const auto read =
      database.rows("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY rowid", [&](const Statement& row) {
        tables.emplace_back(row.bytes(0));
        return true;
      });
  if (!read || std::equal(tables.begin(), tables.end(), std::begin(kTables), std::end(kTables))) return read;
  return database.damaged("its tables are not a store's");
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
    insert("INSERT INTO info VALUES (CAST(? AS TEXT), CAST(? AS TEXT))", key, value);
  visit_chunks(contents, [&](std::string_view name, const std::string& bytes) {
    insert("INSERT INTO records (name, data) VALUES (CAST(? AS TEXT), ?)", name, bytes);
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

Expected<int> stored_dimension(Database& database) {
  const auto info = read_info(database);
  if (!info) return tl::unexpected(info.error());
  int dimension = 0;
  if (take_number(*info, "dimension", dimension) && (dimension == 2 || dimension == 3)) return dimension;
  return database.damaged("its dimension is neither 2 nor 3");
}

template <int Dim>
Expected<StoredMaps<Dim>> read_contents(Database& database) {
  auto info = read_info(database);
  if (!info) return tl::unexpected(info.error());
  StoredMaps<Dim> stored;
  std::string fault;
  const std::optional<Portion> portion = portion_of(*info);
  if (!portion) fault = "info portion makes no sense";
  visit_numbers(stored.log, [&](const char* key, auto& number) {
    if (!take_number(*info, key, number)) fault = fmt::format("info {} is missing or makes no sense", key);
  });
  const auto read = database.rows("SELECT name, data FROM records ORDER BY chunk", [&](const Statement& row) {
    bool is_taken = false;
    visit_arrays(stored.log, stored.segments, [&](std::string_view name, auto& records) {
      if (name == row.bytes(0)) is_taken = decode_all(row.bytes(1), records);
    });
    if (!is_taken) fault = printable(row.bytes(0)) + " is no array, or has part of a record";
    return is_taken;
  });
  if (!read) return tl::unexpected(read.error());
  if (!fault.empty()) return database.damaged(fault);
  const PoseOrder order = portion->is_whole() ? PoseOrder::kDriven : PoseOrder::kOfIds;
  auto built = built_if_sound(stored.log, database.file() + ": damaged store", order);
  if (!built) return database.damaged("its arrays do not hang together");
  Expected<Log<Dim>>& log = *built;
  if (!log) return tl::unexpected(log.error());
  if (log->poses != stored.log.poses || log->features != stored.log.features) {
    return database.damaged("its poses or features are not in order");
  }
  if (!are_in_order(stored.segments, *log)) return database.damaged("its segments are not in order");
  log->source = (*info)["source"];
  return StoredMaps<Dim>{*std::move(log), std::move(stored.segments), {}, (*info)["options"], *portion};
}

#define MAPJOIN_INSTANTIATE(Dim)                                                \
  template Expected<void> write_contents<Dim>(Database&, const Contents<Dim>&); \
  template Expected<bool> holds_contents<Dim>(Database&, const Contents<Dim>&); \
  template bool is_same_log<Dim>(const Log<Dim>&, const Log<Dim>&);             \
  template bool is_same_but_for_factors<Dim>(const Log<Dim>&, const Log<Dim>&); \
  template Expected<StoredMaps<Dim>> read_contents<Dim>(Database&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::store
