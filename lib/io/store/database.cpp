// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <sqlite3.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/store/database.hpp>
#include <system_error>

namespace mapjoin::store {
namespace {

/// What can be done about an unfinished store.
constexpr std::string_view kBuildGoesOn = "the same `mapjoin build` again goes on from there";

bool is_damage(int status) {
  return status == SQLITE_NOTADB || status == SQLITE_CORRUPT;
}

std::string damage_in_words(std::string_view what) {
  return fmt::format("damaged store: {}; build it again", what);
}

/// The reason of a failure: SQLite's words, or others if those are about something else.
std::string reason_of(sqlite3* database, ErrorKind kind) {
  const int status = sqlite3_errcode(database);
  if (is_damage(status)) return damage_in_words(sqlite3_errmsg(database));
  if (status == SQLITE_BUSY) return "another process is writing it";
  if (status == SQLITE_FULL) return "no space left on device; once there is some, the same command again goes on from there";
  // Only the writer of the store can restore its state before the interruption.
  if (status == SQLITE_READONLY && kind == ErrorKind::kBadInput) {
    return fmt::format("unfinished store: its writer was interrupted; {}", kBuildGoesOn);
  }
  const int reason = status == SQLITE_IOERR ? sqlite3_system_errno(database) : 0;
  return reason != 0 ? std::generic_category().message(reason) : sqlite3_errmsg(database);
}

tl::unexpected<Error> error_of(sqlite3* database, const std::string& file, ErrorKind kind) {
  const ErrorKind of_file = is_damage(sqlite3_errcode(database)) ? ErrorKind::kBadInput : kind;
  return tl::unexpected(Error{of_file, fmt::format("{}: {}", file, printable(reason_of(database, kind)))});
}

template <typename Number>
std::string_view bytes_of(const Number& number) {
  return {reinterpret_cast<const char*>(&number), sizeof(number)};
}

/// Adds bytes to a checksum.
uLong add_to(uLong checksum, std::string_view bytes) {
  return crc32_z(checksum, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
}

/// Adds a value to a checksum: its storage class (1 integer, 2 real, 3 text, 4 blob, 5 NULL) as a byte, its size as an i64, and
/// its bytes; an integer is an i64, a real number an f64.
uLong add_to(uLong checksum, sqlite3_value* value) {
  const int storage_class = sqlite3_value_type(value);
  const auto with = [&](std::string_view bytes) {
    checksum = add_to(checksum, bytes_of(static_cast<std::uint8_t>(storage_class)));
    checksum = add_to(checksum, bytes_of(std::int64_t{std::ssize(bytes)}));
    return add_to(checksum, bytes);
  };
  if (storage_class == SQLITE_INTEGER) return with(bytes_of(std::int64_t{sqlite3_value_int64(value)}));
  if (storage_class == SQLITE_FLOAT) return with(bytes_of(sqlite3_value_double(value) + 0.0));  // SQLite keeps no -0.
  const auto* bytes = static_cast<const char*>(sqlite3_value_blob(value));
  return with({bytes ? bytes : "", static_cast<std::size_t>(sqlite3_value_bytes(value))});
}

/// The SQL function crc32(value, ...): the CRC-32 of all values, one after the other.
void take_crc32(sqlite3_context* context, int count, sqlite3_value** values) {
  uLong checksum = crc32_z(0, nullptr, 0);
  for (int k = 0; k < count; ++k) checksum = add_to(checksum, values[k]);
  sqlite3_result_int64(context, static_cast<std::int64_t>(checksum));
}

}  // namespace

void Statement::Finalize::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

Statement& Statement::bind(std::int64_t value) {
  sqlite3_bind_int64(statement_.get(), ++bound_, value);
  return *this;
}

Statement& Statement::bind(double value) {
  sqlite3_bind_double(statement_.get(), ++bound_, value);
  return *this;
}

Statement& Statement::bind(std::string_view bytes) {
  // A null pointer would bind NULL, not an empty blob.
  sqlite3_bind_blob64(statement_.get(), ++bound_, bytes.empty() ? "" : bytes.data(), bytes.size(), SQLITE_STATIC);
  return *this;
}

Expected<bool> Statement::step() {
  const int status = sqlite3_step(statement_.get());
  if (status == SQLITE_ROW) return true;
  sqlite3* database = sqlite3_db_handle(statement_.get());
  if (status != SQLITE_DONE) return error_of(database, file_, kind_);
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
  bound_ = 0;
  return false;
}

bool Statement::is_null(int column) const {
  return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
}

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

double Statement::number(int column) const {
  return sqlite3_column_double(statement_.get(), column);
}

std::string_view Statement::bytes(int column) const {
  const auto* data = static_cast<const char*>(sqlite3_column_blob(statement_.get(), column));
  return {data ? data : "", static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

void Database::Close::operator()(sqlite3* database) const {
  sqlite3_close_v2(database);
}

tl::unexpected<Error> Database::error() const {
  return error_of(database_.get(), file_, kind_);
}

Expected<Database> Database::open(const std::filesystem::path& path, int flags, ErrorKind kind) {
  Database database;
  database.file_ = path.string();
  database.kind_ = kind;
  sqlite3* handle = nullptr;
  const std::filesystem::path plain = "." / path;  // SQLite takes a name that begins with `file:` for a URI.
  const int status = sqlite3_open_v2(plain.c_str(), &handle, flags | SQLITE_OPEN_NOMUTEX, nullptr);
  database.database_.reset(handle);
  if (status != SQLITE_OK) return database.error();
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  constexpr int kFlags = SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_DIRECTONLY;
  constexpr int kAnyNumber = -1;
  if (sqlite3_create_function(handle, "crc32", kAnyNumber, kFlags, nullptr, take_crc32, nullptr, nullptr) != SQLITE_OK) {
    return database.error();
  }
  return database;
}

Expected<Database> Database::open(const std::filesystem::path& path) {
  return open(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, ErrorKind::kCannotWrite);
}

Expected<Database> Database::open_read_only(const std::filesystem::path& path) {
  constexpr std::uintmax_t kLeast = 1 << 16;  // For the texts of SQLite itself.
  auto database = open(path, SQLITE_OPEN_READONLY, ErrorKind::kBadInput);
  if (!database) return database;
  std::error_code failure;
  const std::uintmax_t size = std::filesystem::file_size(path, failure);
  if (failure) return tl::unexpected(Error{ErrorKind::kBadInput, database->file_ + ": " + failure.message()});
  const auto most = std::min<std::uintmax_t>(std::max(size, kLeast), std::numeric_limits<int>::max());
  sqlite3_limit(database->database_.get(), SQLITE_LIMIT_LENGTH, static_cast<int>(most));
  const auto set = database->execute("PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0; BEGIN");
  if (!set) return tl::unexpected(set.error());
  return database;
}

Expected<void> Database::execute(const std::string& sql) {
  if (sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) return error();
  return {};
}

Expected<Statement> Database::prepare(std::string_view sql) {
  sqlite3_stmt* handle = nullptr;
  if (sqlite3_prepare_v2(database_.get(), sql.data(), static_cast<int>(sql.size()), &handle, nullptr) != SQLITE_OK) {
    return error();
  }
  Statement statement;
  statement.statement_.reset(handle);
  statement.file_ = file_;
  statement.kind_ = kind_;
  return statement;
}

Expected<void> Database::rows(std::string_view sql, const std::function<bool(const Statement& row)>& take) {
  auto statement = prepare(sql);
  if (!statement) return tl::unexpected(statement.error());
  auto is_row = statement->step();
  while (is_row && *is_row && take(*statement)) is_row = statement->step();
  return is_row.map([](bool) {});
}

Expected<std::int64_t> Database::integer(std::string_view sql) {
  std::int64_t value = 0;
  return rows(sql,
              [&](const Statement& row) {
                value = row.integer(0);
                return false;
              })
      .map([&] { return value; });
}

tl::unexpected<Error> Database::damaged(std::string_view what) const {
  return bad_input(fmt::format("{}: {}", file_, damage_in_words(what)));
}

tl::unexpected<Error> Database::unfinished(std::size_t segment) const {
  return bad_input(
      fmt::format("{}: unfinished store: the local map of segment {} is missing; {}", file_, segment, kBuildGoesOn));
}

}  // namespace mapjoin::store
