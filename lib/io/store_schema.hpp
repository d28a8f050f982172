// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The tables of a store (docs/store.md), and the numbers in its header that tell it from other SQLite files.

#include <cstdint>
#include <mapjoin/io/store_database.hpp>
#include <mapjoin/model/error.hpp>
#include <string>

namespace mapjoin::store {

/// "MJST".
inline constexpr std::int64_t kApplicationId = 0x4d4a5354;
/// Of the schema and of the records in it; PRAGMA user_version.
inline constexpr std::int64_t kVersion = 1;

inline constexpr const char* kTables[] = {
    R"(CREATE TABLE info (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID)",
    R"(CREATE TABLE records (name TEXT NOT NULL, chunk INTEGER NOT NULL, data BLOB NOT NULL, UNIQUE (name, chunk)))",
    R"(CREATE TABLE maps (
  stretch INTEGER PRIMARY KEY, base INTEGER, chi2 REAL,
  poses BLOB, features BLOB, pose_estimates BLOB, feature_estimates BLOB, information BLOB))",
};

/// Bad input where the database is damaged, or has other tables than these: views, triggers, columns that compute. Errors begin
/// with `file`.
Expected<void> check_database(Database& database, const std::string& file);

}  // namespace mapjoin::store
