// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <mapjoin/io/files/output_file.hpp>
#include <system_error>

namespace mapjoin {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 18;

namespace fs = std::filesystem;

/// True if `path` is a link in /proc, to which /dev/stdout leads: an open file rather than a name.
bool is_open_file(const fs::path& path) {
  std::error_code failure;
  const fs::path folder = fs::canonical(path.has_parent_path() ? path.parent_path() : ".", failure);
  return !failure && folder.native().starts_with("/proc/");
}

}  // namespace

fs::path link_target(fs::path path) {
  constexpr int kMostLinks = 40;
  std::error_code ignored;
  for (int links = 0; links < kMostLinks && !is_open_file(path) && fs::is_symlink(path, ignored); ++links) {
    path = path.parent_path() / fs::read_symlink(path, ignored);
  }
  return path;
}

fs::path destination(const fs::path& path) {
  std::error_code ignored;
  const fs::path place = fs::weakly_canonical(fs::absolute(link_target(path), ignored), ignored);
  return place.has_filename() ? place : place.parent_path();
}

bool are_one_file(const fs::path& a, const fs::path& b) {
  if (a.empty() || b.empty()) return false;
  std::error_code ignored;
  if (fs::exists(a, ignored) || fs::exists(b, ignored)) {
    return fs::is_regular_file(a, ignored) && fs::equivalent(a, b, ignored);
  }
  const fs::path place = destination(a);
  return !place.empty() && place == destination(b);
}

OutputFile::OutputFile(fs::path path, fs::path written_path, Descriptor descriptor)
    : path_(std::move(path)), written_path_(std::move(written_path)), descriptor_(std::move(descriptor)) {
  buffer_.reserve(kBufferSize);
}

void take_permissions_of(const fs::path& replaced, const fs::path& path) {
  std::error_code ignored;
  const fs::file_status there = fs::status(replaced, ignored);
  if (!fs::exists(there)) return;
  if (fs::is_directory(path, ignored)) {
    fs::permissions(path, there.permissions() | fs::perms::owner_all, ignored);
  } else {
    fs::permissions(path, (there.permissions() & fs::perms::all) | fs::perms::owner_write, ignored);
  }
}

Expected<OutputFile> OutputFile::create(const fs::path& path) {
  std::error_code ignored;
  const fs::path target = link_target(path);  // A link stays a link.
  const bool beside = !is_open_file(target) && (!fs::exists(target, ignored) || fs::is_regular_file(target, ignored));
  if (beside && fs::is_symlink(target, ignored)) return call_failed(path, ELOOP, ErrorKind::kCannotWrite);
  if (beside) {
    const fs::path written = target.string() + kUnfinished;
    return open_alone(written, path).map([&](Descriptor&& file) {
      take_permissions_of(target, written);
      return OutputFile(target, written, std::move(file));
    });
  }
  // An open file may have content already, behind which this output goes.
  Descriptor file(::open(target.c_str(), O_WRONLY | O_CLOEXEC | O_APPEND));
  if (!file.is_open()) return call_failed(path, errno, ErrorKind::kCannotWrite);
  return OutputFile(target, target, std::move(file));
}

OutputFile::~OutputFile() {
  if (descriptor_.is_open() && is_beside()) ::unlink(written_path_.c_str());
}

void OutputFile::write(std::string_view bytes) {
  if (buffer_.size() + bytes.size() > kBufferSize) flush();
  buffer_.append(bytes);
}

void OutputFile::flush() {
  if (failure_ == 0) failure_ = write_all(descriptor_.value(), buffer_);
  buffer_.clear();
}

Expected<void> OutputFile::outcome() const {
  if (failure_ == 0) return {};
  return call_failed(path_, failure_, ErrorKind::kCannotWrite);
}

Expected<void> OutputFile::sync() {
  flush();
  if (failure_ == 0 && is_beside() && ::fsync(descriptor_.value()) != 0) failure_ = errno;
  return outcome();
}

Expected<void> OutputFile::commit() {
  (void)sync();
  return commit_unsynced();
}

Expected<void> OutputFile::commit_unsynced() {
  flush();
  // Closing a duplicate shows errors of closing while the lock still holds the name.
  if (failure_ == 0 && ::close(::dup(descriptor_.value())) != 0) failure_ = errno;
  if (failure_ == 0 && is_beside() && std::rename(written_path_.c_str(), path_.c_str()) != 0) failure_ = errno;
  if (failure_ != 0 && is_beside()) ::unlink(written_path_.c_str());
  descriptor_ = Descriptor();
  return outcome();
}

Expected<void> write_file(const fs::path& path, std::string_view bytes) {
  return OutputFile::create(path).and_then([&](OutputFile&& file) {
    file.write(bytes);
    return file.commit();
  });
}

Expected<void> write_file_unsynced(const fs::path& path, std::string_view bytes) {
  return OutputFile::create(path).and_then([&](OutputFile&& file) {
    file.write(bytes);
    return file.commit_unsynced();
  });
}

}  // namespace mapjoin
