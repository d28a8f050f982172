// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The small part of SQLite that the store needs, with errors as values.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mapjoin/model/error.hpp>
#include <memory>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace mapjoin::store {

/// A prepared statement. Values are bound in the order of its parameters, and must live until the next step().
class Statement {
 public:
  Statement& bind(std::int64_t value);
  Statement& bind(double value);
  Statement& bind(std::string_view bytes);
  /// Moves to the next row; false at the end, where the statement begins anew with nothing bound.
  Expected<bool> step();

  /// The value of a column of the current row; views stay valid until the next step().
  bool is_null(int column) const;
  std::int64_t integer(int column) const;
  double number(int column) const;
  std::string_view bytes(int column) const;

 private:
  friend class Database;
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  std::string file_;  ///< For messages.
  ErrorKind kind_ = ErrorKind::kBadInput;
  int bound_ = 0;
};

/// A database file whose schema is not trusted. Errors begin with its path; they are kCannotWrite if it was opened for writing
/// and is not damaged, otherwise bad input. Its statements may call crc32(value, ...), the checksum of a row of a store.
class Database {
 public:
  /// Opens a database for writing, and creates it if missing.
  static Expected<Database> open(const std::filesystem::path& path);
  /// Opens a stranger's file for reading: values larger than the file are refused, and all statements see one state of it.
  static Expected<Database> open_read_only(const std::filesystem::path& path);

  /// Executes statements without parameters and results.
  Expected<void> execute(const std::string& sql);
  Expected<Statement> prepare(std::string_view sql);
  /// Hands every row of the result to `take`, until that returns false.
  Expected<void> rows(std::string_view sql, const std::function<bool(const Statement& row)>& take);
  /// The integer that is the statement's only result.
  Expected<std::int64_t> integer(std::string_view sql);

  const std::string& file() const { return file_; }
  /// A bad-input error about a damaged store.
  tl::unexpected<Error> damaged(std::string_view what) const;
  /// A bad-input error about a store that lacks the local map of this segment.
  tl::unexpected<Error> unfinished(std::size_t segment) const;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  static Expected<Database> open(const std::filesystem::path& path, int flags, ErrorKind kind);
  tl::unexpected<Error> error() const;

  std::unique_ptr<sqlite3, Close> database_;
  std::string file_;
  ErrorKind kind_ = ErrorKind::kBadInput;
};

}  // namespace mapjoin::store
