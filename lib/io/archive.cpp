// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <mapjoin/io/archive.hpp>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <type_traits>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFileSize = std::size_t{4} << 30;
constexpr std::size_t kChunk = std::size_t{1} << 20;
constexpr std::size_t kTarBlock = 512;

struct CloseGz {
  void operator()(gzFile file) const { gzclose_r(file); }
};
using GzFile = std::unique_ptr<std::remove_pointer_t<gzFile>, CloseGz>;

/// A file that is inflated while it is read, or read as it is.
Expected<GzFile> open_file(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return bad_input(fmt::format("{}: is a folder", path.string()));
  GzFile file(gzopen(path.c_str(), "rb"));
  if (!file) return bad_input(fmt::format("{}: cannot be read", path.string()));
  return file;
}

/// The next `size` bytes, fewer at the end. Grows by chunks: a false size costs no memory.
Expected<std::string> read_bytes(gzFile file, std::size_t size, const fs::path& path) {
  std::string bytes;
  while (bytes.size() < size) {
    const std::size_t begin = bytes.size();
    const std::size_t chunk = std::min(size - begin, kChunk);
    bytes.resize(begin + chunk);
    const int got = gzread(file, bytes.data() + begin, static_cast<unsigned>(chunk));
    int status = Z_OK;
    gzerror(file, &status);
    if (got < 0 || status != Z_OK) return bad_input(fmt::format("{}: damaged or cut short", path.string()));
    bytes.resize(begin + static_cast<std::size_t>(got));
    if (static_cast<std::size_t>(got) < chunk) break;
  }
  return bytes;
}

struct TarMember {
  std::string name;  ///< Without its folders.
  std::size_t size = 0;
  bool is_file = false;
};

bool is_tar_header(std::string_view block) {
  return block.size() == kTarBlock && block.substr(257, 5) == "ustar";
}

std::optional<std::size_t> octal(std::string_view field) {
  field.remove_prefix(std::min(field.find_first_not_of(' '), field.size()));
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value, 8);
  if (error != std::errc() || (end != field.data() + field.size() && *end != '\0' && *end != ' ')) return std::nullopt;
  return value;
}

/// What the header block of a tar member says; empty where it is not one or its checksum is wrong.
std::optional<TarMember> parse_tar_header(std::string_view block) {
  if (!is_tar_header(block)) return std::nullopt;
  const auto size = octal(block.substr(124, 12));
  const auto checksum = octal(block.substr(148, 8));
  if (!size || !checksum || *size > kMaxFileSize) return std::nullopt;
  const auto add = [](std::size_t sum, char c) { return sum + static_cast<unsigned char>(c); };
  // The checksum counts its own eight bytes as blanks.
  const std::size_t own = std::accumulate(block.begin() + 148, block.begin() + 156, std::size_t{0}, add);
  if (std::accumulate(block.begin(), block.end(), std::size_t{0}, add) - own + 8 * ' ' != *checksum) return std::nullopt;
  const std::string_view field = block.substr(0, 100);
  const std::string_view name = field.substr(0, field.find('\0'));
  return TarMember{std::string(name.substr(name.rfind('/') + 1)), *size, block[156] == '0' || block[156] == '\0'};
}

Expected<void> visit_archive(const fs::path& path, const WantFile& want, const VisitFile& visit) {
  const auto file = open_file(path);
  if (!file) return tl::unexpected(file.error());
  while (true) {
    const auto block = read_bytes(file->get(), kTarBlock, path);
    if (!block) return tl::unexpected(block.error());
    if (block->empty() || *block == std::string(kTarBlock, '\0')) return {};
    const auto member = parse_tar_header(*block);
    if (!member) return bad_input(fmt::format("{}: damaged archive: a member's header is wrong", path.string()));
    const std::size_t padded = (member->size + kTarBlock - 1) / kTarBlock * kTarBlock;
    auto bytes = read_bytes(file->get(), padded, path);
    if (!bytes) return tl::unexpected(bytes.error());
    if (bytes->size() < member->size) {
      return bad_input(fmt::format("{}: damaged archive: it ends inside {}", path.string(), member->name));
    }
    if (!member->is_file || !want(member->name)) continue;
    bytes->resize(member->size);
    if (auto done = visit(path / member->name, std::move(*bytes)); !done) return done;
  }
}

Expected<void> visit_folder(const fs::path& folder, const WantFile& want, const VisitFile& visit) {
  std::error_code error;
  std::set<fs::path> paths;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (want(entry->path().filename().string())) paths.insert(entry->path());
  }
  if (error) return bad_input(fmt::format("{}: cannot be read: {}", folder.string(), error.message()));
  for (const fs::path& path : paths) {
    auto bytes = read_whole_file(path);
    if (!bytes) return tl::unexpected(bytes.error());
    if (auto done = visit(path, std::move(*bytes)); !done) return done;
  }
  return {};
}

}  // namespace

bool is_tar_archive(const fs::path& path) {
  const auto file = open_file(path);
  const auto block = file ? read_bytes(file->get(), kTarBlock, path) : bad_input("");
  return block && is_tar_header(*block);
}

Expected<std::string> read_whole_file(const fs::path& path) {
  const auto file = open_file(path);
  if (!file) return tl::unexpected(file.error());
  auto bytes = read_bytes(file->get(), kMaxFileSize + 1, path);
  if (bytes && bytes->size() > kMaxFileSize) {
    return tl::unexpected(Error{ErrorKind::kTooLarge, fmt::format("{}: holds more than 4 GiB", path.string())});
  }
  return bytes;
}

Expected<void> visit_files(const fs::path& folder_or_archive, const WantFile& want, const VisitFile& visit) {
  std::error_code error;
  return fs::is_directory(folder_or_archive, error) ? visit_folder(folder_or_archive, want, visit)
                                                    : visit_archive(folder_or_archive, want, visit);
}

}  // namespace mapjoin
