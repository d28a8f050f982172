// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <mapjoin/io/files/system_call.hpp>
#include <system_error>

namespace mapjoin {
namespace {

/// The error of opening `path` for `output`: in_the_way() if a folder or a link has the name, otherwise `reason` in words.
tl::unexpected<Error> cannot_open(const std::filesystem::path& path, const std::filesystem::path& output, int reason) {
  std::error_code ignored;
  const auto there = std::filesystem::symlink_status(path, ignored);
  if (std::filesystem::is_directory(there) || std::filesystem::is_symlink(there)) return in_the_way(path, output);
  return call_failed(output, reason, ErrorKind::kCannotWrite);
}

}  // namespace

Descriptor Descriptor::to_read(const std::filesystem::path& path) {
  return Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
}

Descriptor::~Descriptor() {
  if (is_open()) ::close(value_);
}

tl::unexpected<Error> call_failed(const std::filesystem::path& path, int reason, ErrorKind kind) {
  return tl::unexpected(Error{reason == EINTR ? ErrorKind::kInterrupted : kind,
                              fmt::format("{}: {}", path.string(), std::generic_category().message(reason))});
}

int write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ::ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0) return errno;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

bool has_name(int descriptor, const std::filesystem::path& path) {
  struct stat opened {};
  struct stat named {};
  return ::fstat(descriptor, &opened) == 0 && ::stat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

tl::unexpected<Error> in_the_way(const std::filesystem::path& path, const std::filesystem::path& output) {
  const std::string words = fmt::format("{} is in the way of {}: remove it", path.string(), output.string());
  return tl::unexpected(Error{ErrorKind::kCannotWrite, words});
}

Expected<Descriptor> open_alone(const std::filesystem::path& path, const std::filesystem::path& output) {
  while (true) {
    Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_CREAT | O_NOFOLLOW, 0666));
    if (!file.is_open()) return cannot_open(path, output, errno);
    // On a file system without locks the last writer wins.
    if (::flock(file.value(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      return tl::unexpected(Error{ErrorKind::kCannotWrite, fmt::format("{}: another process is writing it", output.string())});
    }
    if (!has_name(file.value(), path)) continue;
    if (::ftruncate(file.value(), 0) == 0) return file;
    return call_failed(output, errno, ErrorKind::kCannotWrite);
  }
}

}  // namespace mapjoin
