// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <mapjoin/io/archive.hpp>
#include <mapjoin/io/file_bytes.hpp>
#include <numeric>
#include <optional>
#include <set>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;

/// A tar archive is made of blocks of this size: a member's header, then its content, filled up to whole blocks.
constexpr std::size_t kBlock = 512;

struct Member {
  std::string name;  ///< Without its folders.
  std::size_t size = 0;
  bool is_file = false;
};

std::optional<std::size_t> octal(std::string_view field) {
  field.remove_prefix(std::min(field.find_first_not_of(' '), field.size()));
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value, 8);
  if (error != std::errc() || (end != field.data() + field.size() && *end != '\0' && *end != ' ')) return std::nullopt;
  return value;
}

/// What a header says; nothing where it is not one or its checksum is wrong.
std::optional<Member> parse_header(std::string_view block) {
  if (!is_tar_archive(block)) return std::nullopt;
  const auto size = octal(block.substr(124, 12));
  const auto checksum = octal(block.substr(148, 8));
  if (!size || !checksum) return std::nullopt;
  const auto add = [](std::size_t sum, char c) { return sum + static_cast<unsigned char>(c); };
  // The checksum counts its own eight bytes as blanks.
  const std::size_t own = std::accumulate(block.begin() + 148, block.begin() + 156, std::size_t{0}, add);
  if (std::accumulate(block.begin(), block.end(), std::size_t{0}, add) - own + std::size_t{8} * ' ' != *checksum) return std::nullopt;
  const std::string_view field = block.substr(0, 100);
  const std::string_view name = field.substr(0, field.find('\0'));
  return Member{std::string(name.substr(name.rfind('/') + 1)), *size, block[156] == '0' || block[156] == '\0'};
}

Expected<void> visit_archive(const fs::path& path, const WantFile& want, const VisitFile& visit) {
  const auto bytes = FileBytes::read(path);
  if (!bytes) return tl::unexpected(bytes.error());
  if (!is_tar_archive(bytes->view()))
    return bad_input(fmt::format("{}: neither a folder nor a tar archive nor a mapjoin store", path.string()));
  std::string_view rest = bytes->view();
  while (!rest.empty() && rest.substr(0, kBlock) != std::string(kBlock, '\0')) {
    const auto member = parse_header(rest.substr(0, kBlock));
    if (!member) return bad_input(fmt::format("{}: damaged archive: a member's header is wrong", path.string()));
    rest.remove_prefix(kBlock);
    if (member->size > rest.size()) {
      return bad_input(fmt::format("{}: damaged archive: it ends inside {}", path.string(), member->name));
    }
    if (member->is_file && want(member->name)) {
      if (auto done = visit(path / member->name, rest.substr(0, member->size)); !done) return done;
    }
    rest.remove_prefix(std::min(rest.size(), (member->size + kBlock - 1) / kBlock * kBlock));
  }
  return {};
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
