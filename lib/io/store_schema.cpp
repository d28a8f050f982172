// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/store_schema.hpp>
#include <mapjoin/io/text_scanner.hpp>

namespace mapjoin::store {
namespace {

Expected<void> check_integrity(Database& database, const std::string& file) {
  auto check = database.prepare("PRAGMA quick_check(1)");
  if (!check) return tl::unexpected(check.error());
  const auto row = check->step();
  if (!row) return tl::unexpected(row.error());
  const std::string_view found = *row ? check->bytes(0) : "its check has no result";
  if (found == "ok") return {};
  // What is wrong stands below a line that names the database.
  return bad_input(fmt::format("{}: damaged store: {}", file, printable(found.substr(found.rfind('\n') + 1))));
}

/// The schema is ours to the letter.
Expected<void> check_schema(Database& database, const std::string& file) {
  auto select = database.prepare("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY rowid");
  if (!select) return tl::unexpected(select.error());
  for (const char* table : kTables) {
    const auto row = select->step();
    if (!row) return tl::unexpected(row.error());
    if (!*row || select->bytes(0) != table) {
      return bad_input(fmt::format("{}: damaged store: its tables are not a store's", file));
    }
  }
  const auto more = select->step();
  if (!more) return tl::unexpected(more.error());
  if (*more) return bad_input(fmt::format("{}: damaged store: it has more tables than a store", file));
  return {};
}

}  // namespace

Expected<void> check_database(Database& database, const std::string& file) {
  return check_integrity(database, file).and_then([&] { return check_schema(database, file); });
}

}  // namespace mapjoin::store
