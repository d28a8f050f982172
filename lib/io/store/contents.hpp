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

/// Which of the factors of a log a store has: all, or those of one of several processes, none of which had the whole log.
struct Portion {
  std::size_t index = 0;  ///< From 0.
  std::size_t count = 1;

  bool is_whole() const { return count == 1; }
  bool operator==(const Portion&) const = default;
};

/// Bad input where these stores of portions of one log, `source`, are not all of them, each once.
Expected<void> check_complete(std::vector<Portion> portions, const std::string& source);
/// Bad input where two parts of a log, `source`, are cut into different segments.
Expected<void> check_cut_alike(const std::vector<Segment>& one, const std::vector<Segment>& other, const std::string& source);

/// What a finished store holds.
template <int Dim>
struct StoredMaps {
  Log<Dim> log;
  std::vector<Segment> segments;    ///< Those whose map could not be determined are raw segments here.
  std::vector<LocalMap<Dim>> maps;  ///< Of the segments that are maps, in their order.
  std::string options;              ///< Of the build, as given to StoreWriter.
  Portion portion = {};
};

}  // namespace mapjoin

namespace mapjoin::store {

/// "MJST": PRAGMA application_id.
inline constexpr std::int64_t kApplicationId = 0x4d4a5354;
/// Of the tables and of the records in them: PRAGMA user_version.
inline constexpr std::int64_t kVersion = 4;

/// What a build begins with.
template <int Dim>
struct Contents {
  const Log<Dim>& log;
  const std::vector<Segment>& segments;
  const std::string& options;  ///< Of the build, in the words of whoever builds.
  Portion portion = {};
};

/// Makes the tables in an empty database, and fills `info` and `records`.
template <int Dim>
Expected<void> write_contents(Database& database, const Contents<Dim>& contents);

/// Whether the tables hold these contents, to the bit.
template <int Dim>
Expected<bool> holds_contents(Database& database, const Contents<Dim>& contents);

/// Whether stores keep one and the same log, to the bit.
template <int Dim>
bool is_same_log(const Log<Dim>& a, const Log<Dim>& b);

/// Whether stores keep portions of one log: all that is alike in them is, to the bit.
template <int Dim>
bool is_same_but_for_factors(const Log<Dim>& a, const Log<Dim>& b);

/// A finished store, for reading, yet to be checked as below. Bad input: not a mapjoin store, or one of another version.
Expected<Database> open_store(const std::filesystem::path& path);

/// Bad input where the database is damaged, or has other tables than a store's: views, triggers, columns that compute.
Expected<void> check_database(Database& database);

/// 2 or 3.
Expected<int> stored_dimension(Database& database);

/// A stranger's contents: the log is built anew by LogBuilder, which checks its numbers and puts it in order; segments are in
/// order and made of poses of the log. The maps are yet to be read.
template <int Dim>
Expected<StoredMaps<Dim>> read_contents(Database& database);

/// The same of names, fixed poses and segments alone, in the order in which they stand.
template <int Dim>
Expected<StoredMaps<Dim>> read_outline(Database& database);

/// Appends the factors in some chunks, as they stand.
template <int Dim>
Expected<void> read_factors(Database& database, std::span<const std::int64_t> chunks, FactorGraph<Dim>& graph);

}  // namespace mapjoin::store
