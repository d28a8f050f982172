// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The tables of a store (docs/store.md), and a log with its segments in them.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mapjoin/io/store/database.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/segment.hpp>
#include <span>
#include <string>
#include <vector>

namespace mapjoin {

/// The portion of a log's factors that a store has: all, or those of one of several processes, none of which had the whole log.
struct Portion {
  std::size_t index = 0;  ///< Counted from 0.
  std::size_t count = 1;

  bool is_whole() const { return count == 1; }
  bool operator==(const Portion&) const = default;
};

/// Bad input unless these portions of the log `source` are all of them, each once.
Expected<void> check_complete(std::vector<Portion> portions, const std::string& source);
/// Bad input if two parts of the log `source` are cut into different segments.
Expected<void> check_cut_alike(const std::vector<Segment>& one, const std::vector<Segment>& other, const std::string& source);

/// The content of a finished store.
template <int Dim>
struct StoredMaps {
  Log<Dim> log;
  std::vector<Segment> segments;    ///< Segments whose map could not be determined are raw here.
  std::vector<LocalMap<Dim>> maps;  ///< Maps of the segments that are maps, in their order.
  std::string options;              ///< Options of the build, as given to StoreWriter.
  Portion portion = {};
  Share share = {};  ///< Share of the local maps that were to be built.
  /// True if the user said that features of the same id are the same in the several inputs of the build.
  bool features_are_shared = false;
};

}  // namespace mapjoin

namespace mapjoin::store {

/// The application id "MJST": PRAGMA application_id.
inline constexpr std::int64_t kApplicationId = 0x4d4a5354;
/// The version of the tables and of the records in them: PRAGMA user_version.
inline constexpr std::int64_t kVersion = 5;

/// The contents that a build begins with.
template <int Dim>
struct Contents {
  const Log<Dim>& log;
  const std::vector<Segment>& segments;
  const std::string& options;  ///< Options of the build, in the words of the builder.
  Portion portion = {};
  Share share = {};
  bool features_are_shared = false;
};

/// Makes the tables in an empty database, and fills `info` and `records`.
template <int Dim>
Expected<void> write_contents(Database& database, const Contents<Dim>& contents);

/// True if the tables hold these contents, bit by bit.
template <int Dim>
Expected<bool> holds_contents(Database& database, const Contents<Dim>& contents);

/// True if two logs have the same names, factors, fixed poses, time stamps and initial values, bit by bit.
template <int Dim>
bool is_same_log(const Log<Dim>& a, const Log<Dim>& b);

/// True if two logs are the same but for their factors, bit by bit, as portions of one log are.
template <int Dim>
bool is_same_but_for_factors(const Log<Dim>& a, const Log<Dim>& b);

/// Opens a finished store for reading; check_database() is yet to be called. Bad input: not a mapjoin store, or one of another
/// version.
Expected<Database> open_store(const std::filesystem::path& path);

/// Bad input if the database is damaged, a row is not as it was written, or it has other tables than a store: views, triggers,
/// computed columns.
Expected<void> check_database(Database& database);

/// The dimension of a store's log, 2 or 3.
Expected<int> stored_dimension(Database& database);

/// The contents of a store that is not trusted: LogBuilder builds the log anew, checks its numbers and puts it in order;
/// segments are in order and made of poses of the log. The maps are yet to be read.
template <int Dim>
Expected<StoredMaps<Dim>> read_contents(Database& database);

/// The names, fixed poses and segments of a store that is not trusted, in the order in which they stand; they are checked.
template <int Dim>
Expected<StoredMaps<Dim>> read_outline(Database& database);

/// Appends the factors in some chunks, as they stand.
template <int Dim>
Expected<void> read_factors(Database& database, std::span<const std::int64_t> chunks, FactorGraph<Dim>& graph);

}  // namespace mapjoin::store
