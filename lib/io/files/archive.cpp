// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <mapjoin/io/files/archive.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <numeric>
#include <optional>
#include <set>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;

/// A tar archive is made of blocks of this size: a member's header, then its content, filled up to whole blocks.
constexpr std::size_t kBlock = 512;

struct Member {
  std::string_view name;  ///< Up to 100 bytes; a longer name precedes it, as the content of a header of its own.
  std::size_t size = 0;
  char type = '0';
};

std::string_view up_to_null(std::string_view text) {
  return text.substr(0, text.find('\0'));
}

std::string_view without_folders(std::string_view name) {
  return name.substr(name.rfind('/') + 1);
}

std::optional<std::size_t> octal(std::string_view field) {
  field.remove_prefix(std::min(field.find_first_not_of(' '), field.size()));
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value, 8);
  if (error != std::errc() || (end != field.data() + field.size() && *end != '\0' && *end != ' ')) return std::nullopt;
  return value;
}

/// The member that a header describes; nullopt if the block is no header or its checksum is wrong.
std::optional<Member> parse_header(std::string_view block) {
  if (!is_tar_archive(block)) return std::nullopt;
  const auto size = octal(block.substr(124, 12));
  const auto checksum = octal(block.substr(148, 8));
  if (!size || !checksum) return std::nullopt;
  const auto add = [](std::size_t sum, char c) { return sum + static_cast<unsigned char>(c); };
  // The checksum counts its own eight bytes as blanks.
  const std::size_t own = std::accumulate(block.begin() + 148, block.begin() + 156, std::size_t{0}, add);
  if (std::accumulate(block.begin(), block.end(), std::size_t{0}, add) - own + std::size_t{8} * ' ' != *checksum)
    return std::nullopt;
  return Member{up_to_null(block.substr(0, 100)), *size, block[156]};
}

/// The path among the records `<length> <key>=<value>\n` of a POSIX header, empty if none is; nullopt if they are malformed.
std::optional<std::string_view> pax_path(std::string_view records) {
  constexpr std::string_view kKey = " path=";
  std::string_view path;
  while (!records.empty()) {
    std::size_t length = 0;
    const auto [key, error] = std::from_chars(records.data(), records.data() + records.size(), length);
    const auto digits = static_cast<std::size_t>(key - records.data());
    if (error != std::errc() || length > records.size() || length < digits + 2) return std::nullopt;
    const std::string_view rest = records.substr(digits, length - digits - 1);
    if (rest.starts_with(kKey)) path = rest.substr(kKey.size());
    records.remove_prefix(length);
  }
  return path;
}

/// Visits the wanted files of the archive `path` with the content `rest`.
Expected<void> visit_members(const fs::path& path, std::string_view rest, const WantFile& want, const VisitFile& visit) {
  const auto damaged = [&](std::string_view what) {
    return bad_input(fmt::format("{}: damaged archive: {}", path.string(), what));
  };
  std::string_view long_name;  // Long name of the next member; empty if none.
  while (rest.size() >= kBlock) {
    if (rest.substr(0, kBlock) == std::string(kBlock, '\0')) return {};
    const auto member = parse_header(rest.substr(0, kBlock));
    if (!member) return damaged("a member's header is wrong");
    rest.remove_prefix(kBlock);
    const std::string name(without_folders(long_name.empty() ? member->name : long_name));
    if (member->size > rest.size()) return damaged("it ends inside " + in_quotes(name));
    const std::string_view content = rest.substr(0, member->size);
    if (member->type == 'L') {  // GNU's long name.
      long_name = up_to_null(content);
    } else if (member->type == 'x') {
      const auto given = pax_path(content);
      if (!given) return damaged("a member's header is wrong");
      if (!given->empty()) long_name = *given;
    } else if (member->type != 'K' && member->type != 'g') {  // These name a link's target, or describe all members.
      const bool is_file = member->type == '0' || member->type == '\0';
      if (is_file && want(name)) {
        const auto bytes = FileBytes::of_member(path / name, content);
        if (!bytes) return tl::unexpected(bytes.error());
        if (auto done = visit(path / name, bytes->view()); !done) return done;
      }
      long_name = {};
    }
    rest.remove_prefix(std::min(rest.size(), (member->size + kBlock - 1) / kBlock * kBlock));
  }
  return damaged("it is cut off");
}

Expected<void> visit_archive(const fs::path& path, const WantFile& want, const VisitFile& visit) {
  const auto bytes = FileBytes::read(path);
  if (!bytes) return tl::unexpected(bytes.error());
  if (!is_tar_archive(bytes->view()))
    return bad_input(fmt::format("{}: neither a folder nor a tar archive nor a mapjoin store", path.string()));
  return visit_members(path, bytes->view(), want, visit);
}

Expected<void> visit_folder(const fs::path& folder, const WantFile& want, const VisitFile& visit) {
  std::error_code error;
  std::set<fs::path> paths;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (want(entry->path().filename().string())) paths.insert(entry->path());
  }
  if (error) return bad_input(fmt::format("{}: {}", folder.string(), error.message()));
  for (const fs::path& path : paths) {
    const auto bytes = FileBytes::read(path);
    if (!bytes) return tl::unexpected(bytes.error());
    if (auto done = visit(path, bytes->view()); !done) return done;
  }
  return {};
}

}  // namespace

bool is_tar_archive(std::string_view bytes) {
  return bytes.size() >= kBlock && bytes.substr(257, 5) == "ustar";
}

Expected<void> visit_files(const fs::path& folder_or_archive, const WantFile& want, const VisitFile& visit) {
  std::error_code error;
  return fs::is_directory(folder_or_archive, error) ? visit_folder(folder_or_archive, want, visit)
                                                    : visit_archive(folder_or_archive, want, visit);
}

}  // namespace mapjoin
