// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <mapjoin/io/files/csv_text.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/formats/pose_tables.hpp>
#include <mapjoin/io/formats/trajectory.hpp>
#include <string>

namespace mapjoin {
namespace {

/// The poses of each key, in all sessions.
template <int Dim>
std::multimap<std::uint64_t, PoseIndex> poses_by_key(const Log<Dim>& log) {
  std::multimap<std::uint64_t, PoseIndex> poses;
  for (const PoseIndex p : indices(log.poses)) poses.emplace(log.poses[p].key, p);
  return poses;
}

}  // namespace

template <int Dim>
Expected<void> read_stamps(const std::filesystem::path& path, Log<Dim>& log) {
  const auto bytes = FileBytes::read(path);
  if (!bytes) return tl::unexpected(bytes.error());
  const std::string blanks = with_blanks(bytes->view());
  TextScanner text(path.string(), blanks);
  const auto poses = poses_by_key(log);
  Table<PoseIndex, std::optional<std::int64_t>> stamps(log.poses.size());
  for (bool is_first = true; text.next_line(); is_first = false) {
    const std::string_view word = text.word();
    const auto key = parse_key(word);
    if (!key && is_first) continue;
    if (!key) return text.error(fmt::format("{} stands where an id is expected", in_quotes(word)));
    const auto [begin, end] = poses.equal_range(*key);
    if (begin == end) continue;
    const PoseIndex pose = begin->second;
    if (std::next(begin) != end)
      return text.error(fmt::format(
          "several sessions have a pose {}; stamp each log by itself, by `mapjoin run LOG --stamps FILE -o DIR`, and run on "
          "the folders",
          key_text(*key)));
    if (stamps[pose]) return text.error(fmt::format("{} has two times; keep one", to_string(log.poses[pose])));
    stamps[pose] = read_time(text);
    while (!text.at_end_of_line()) text.word();
    if (auto line = text.finish_line(); !line) return line;
  }
  const auto missing = std::ranges::find_if(stamps, [](const auto& stamp) { return !stamp; });
  if (missing != stamps.end()) {
    return bad_input(fmt::format("{}: has no time for {}; every pose takes one", path.string(),
                                 to_string(log.poses[PoseIndex(missing - stamps.begin())])));
  }
  log.stamps_ns.clear();
  for (const auto& stamp : stamps) log.stamps_ns.push_back(*stamp);
  return {};
}

template <int Dim>
Expected<void> take_ids_as_stamps(Log<Dim>& log) {
  constexpr auto kLast = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  const auto is_no_time = [](const PoseId& id) { return id.key > kLast || symbol_letter(id.key) != '\0'; };
  const auto wrong = std::ranges::find_if(log.poses, is_no_time);
  if (wrong != log.poses.end()) {
    const std::string_view why = wrong->key > kLast ? "2^63 ns or more" : "it is a GTSAM symbol";
    return bad_input_of(log.source, fmt::format("the id of {} is no time: {}; --stamps gives times", to_string(*wrong), why));
  }
  log.stamps_ns.clear();
  for (const PoseId& id : log.poses) log.stamps_ns.push_back(static_cast<std::int64_t>(id.key));
  return {};
}

template Expected<void> read_stamps(const std::filesystem::path&, Log<2>&);
template Expected<void> read_stamps(const std::filesystem::path&, Log<3>&);
template Expected<void> take_ids_as_stamps(Log<2>&);
template Expected<void> take_ids_as_stamps(Log<3>&);

}  // namespace mapjoin
