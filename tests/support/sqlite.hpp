// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Access to a database file, as any other tool has it.

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <string>

namespace mapjoin::testing {

inline void execute_sql(const std::filesystem::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
  sqlite3_close(database);
}

/// The first column of the first row of a query's result.
inline std::string sql_result(const std::filesystem::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  std::string result;
  const auto take = [](void* into, int, char** values, char**) {
    *static_cast<std::string*>(into) = values[0];
    return 1;
  };
  sqlite3_exec(database, sql.c_str(), take, &result, nullptr);
  sqlite3_close(database);
  return result;
}

}  // namespace mapjoin::testing
