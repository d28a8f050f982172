// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <mapjoin/io/store_check.hpp>
#include <mapjoin/io/store_log.hpp>
#include <mapjoin/io/store_records.hpp>

namespace mapjoin::store {
namespace {

constexpr std::size_t kChunkSize = std::size_t{1} << 20;
constexpr const char* kSelectChunks = "SELECT data FROM records WHERE name = ? ORDER BY chunk";

/// Hands every array to `visit`, with its name in the file.
template <typename Contents, typename Visit>
void visit_arrays(Contents& contents, const Visit& visit) {
  auto& log = contents.log;
  visit("poses", log.poses);
  visit("features", log.features);
  visit("sessions", log.sessions);
  visit("odometry", log.odometry);
  visit("closures", log.closures);
  visit("observations", log.observations);
  visit("pose_priors", log.pose_priors);
  visit("feature_priors", log.feature_priors);
  visit("fixed", log.fixed);
  visit("stamps_ns", log.stamps_ns);
  visit("initial_poses", log.initial_poses);
  visit("initial_features", log.initial_features);
  visit("stretches", contents.stretches);
}

/// Hands every number that stands alone to `visit`, with its name in the file.
template <typename Log, typename Visit>
void visit_numbers(Log& log, const Visit& visit) {
  visit("repeated_edges", log.repeated_edges);
  visit("unassociated", log.unassociated);
  visit("repaired_informations", log.conventions.repaired_informations);
  visit("pose_error", log.conventions.pose_error);
  visit("rotation_information", log.conventions.rotation_information);
  visit("covariance", log.conventions.covariance);
}

using Info = std::map<std::string, std::string>;

template <int Dim>
Info info_of(const Contents<Dim>& contents) {
  Info info{{"dimension", std::to_string(Dim)}, {"source", contents.log.source}, {"options", contents.options}};
  visit_numbers(contents.log,
                [&](const char* key, auto number) { info[key] = std::to_string(static_cast<std::int64_t>(number)); });
  return info;
}

Expected<Info> read_info(Database& database) {
  auto select = database.prepare("SELECT key, value FROM info");
  if (!select) return tl::unexpected(select.error());
  Info info;
  while (true) {
    const auto row = select->step();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return info;
    info[std::string(select->bytes(0))] = select->bytes(1);
  }
}

Expected<void> write_info(Database& database, const Info& info) {
  auto insert = database.prepare("INSERT INTO info VALUES (?, ?)");
  if (!insert) return tl::unexpected(insert.error());
  for (const auto& [key, value] : info) {
    if (const auto done = insert->bind_text(key).bind_text(value).step(); !done) return tl::unexpected(done.error());
  }
  return {};
}

/// The number that `info` has under `key`; an enumeration's is 0 or 1. False where there is none.
template <typename Number>
bool take_number(const Info& info, const char* key, Number& number) {
  const auto found = info.find(key);
  if (found == info.end()) return false;
  const std::string& text = found->second;
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0) return false;
  if (std::is_enum_v<Number> && value > 1) return false;
  number = static_cast<Number>(value);
  return true;
}

template <typename Record>
Expected<void> write_array(Statement& insert, const char* name, const std::vector<Record>& records) {
  const std::size_t per_chunk = std::max<std::size_t>(1, kChunkSize / record_size<Record>());
  for (std::size_t begin = 0, chunk = 0; begin < records.size(); begin += per_chunk, ++chunk) {
    const std::string bytes = encode_all(records, begin, std::min(begin + per_chunk, records.size()));
    const auto done = insert.bind_text(name).bind(static_cast<std::int64_t>(chunk)).bind_blob(bytes).step();
    if (!done) return tl::unexpected(done.error());
  }
  return {};
}

/// Hands every chunk of the array to `take`, in order.
template <typename Take>
Expected<void> read_chunks(Statement& select, const char* name, const Take& take) {
  select.bind_text(name);
  while (true) {
    const auto row = select.step();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return {};
    take(select.bytes(0));
  }
}

template <typename Record>
Expected<bool> holds_array(Statement& select, const char* name, const std::vector<Record>& records) {
  std::size_t begin = 0;
  bool same = true;
  const auto read = read_chunks(select, name, [&](std::string_view bytes) {
    const std::size_t end = std::min(records.size(), begin + bytes.size() / record_size<Record>());
    same = same && bytes == encode_all(records, begin, end);
    begin = end;
  });
  return read.map([&] { return same && begin == records.size(); });
}

template <typename Record>
Expected<void> read_array(Statement& select, const std::string& file, const char* name, std::vector<Record>& records) {
  bool whole = true;
  const auto read = read_chunks(select, name, [&](std::string_view bytes) { whole = whole && decode_all(bytes, records); });
  if (read && !whole) return bad_input(fmt::format("{}: damaged store: {} has part of a record", file, name));
  return read;
}

}  // namespace

template <int Dim>
Expected<void> write_contents(Database& database, const Contents<Dim>& contents) {
  Expected<void> result = write_info(database, info_of(contents));
  auto insert = database.prepare("INSERT INTO records VALUES (?, ?, ?)");
  if (!insert) return tl::unexpected(insert.error());
  visit_arrays(contents, [&](const char* name, const auto& records) {
    if (result) result = write_array(*insert, name, records);
  });
  return result;
}

template <int Dim>
Expected<bool> holds_contents(Database& database, const Contents<Dim>& contents) {
  Expected<bool> result = read_info(database).map([&](const Info& info) { return info == info_of(contents); });
  auto select = database.prepare(kSelectChunks);
  if (!select) return tl::unexpected(select.error());
  visit_arrays(contents, [&](const char* name, const auto& records) {
    if (result && *result) result = holds_array(*select, name, records);
  });
  return result;
}

Expected<int> stored_dimension(Database& database, const std::string& file) {
  const auto info = read_info(database);
  if (!info) return tl::unexpected(info.error());
  int dimension = 0;
  if (take_number(*info, "dimension", dimension) && (dimension == 2 || dimension == 3)) return dimension;
  return bad_input(fmt::format("{}: damaged store: its dimension is neither 2 nor 3", file));
}

template <int Dim>
Expected<ReadContents<Dim>> read_contents(Database& database, const std::string& file) {
  const auto info = read_info(database);
  if (!info) return tl::unexpected(info.error());
  ReadContents<Dim> contents;
  Expected<void> result;
  visit_numbers(contents.log, [&](const char* key, auto& number) {
    if (result && !take_number(*info, key, number)) {
      result = bad_input(fmt::format("{}: damaged store: info {} is missing or makes no sense", file, key));
    }
  });
  if (const auto source = info->find("source"); source != info->end()) contents.log.source = source->second;
  if (const auto options = info->find("options"); options != info->end()) contents.options = options->second;

  auto select = database.prepare(kSelectChunks);
  if (!select) return tl::unexpected(select.error());
  visit_arrays(contents, [&](const char* name, auto& records) {
    if (result) result = read_array(*select, file, name, records);
  });
  if (result) result = check_log(contents.log, file);
  if (result) result = check_stretches(contents.stretches, contents.log, file);
  if (!result) return tl::unexpected(result.error());
  return contents;
}

template Expected<void> write_contents<2>(Database&, const Contents<2>&);
template Expected<void> write_contents<3>(Database&, const Contents<3>&);
template Expected<bool> holds_contents<2>(Database&, const Contents<2>&);
template Expected<bool> holds_contents<3>(Database&, const Contents<3>&);
template Expected<ReadContents<2>> read_contents<2>(Database&, const std::string&);
template Expected<ReadContents<3>> read_contents<3>(Database&, const std::string&);

}  // namespace mapjoin::store
