// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/system_call.hpp>
#include <system_error>
#include <utility>

namespace mapjoin {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 18;
constexpr const char* kUnfinished = ".mapjoin-tmp";

namespace fs = std::filesystem;

/// Whether `path` is a link in /proc, as /dev/stdout leads to: an open file rather than a name.
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

OutputFile::OutputFile(std::filesystem::path path, std::filesystem::path written_path, int descriptor)
    : path_(std::move(path)), written_path_(std::move(written_path)), descriptor_(descriptor) {
  buffer_.reserve(kBufferSize);
}

Expected<OutputFile> OutputFile::create(const fs::path& path) {
  std::error_code ignored;
  const fs::path target = link_target(path);  // A link stays a link.
  const bool beside = !is_open_file(target) && (!fs::exists(target, ignored) || fs::is_regular_file(target, ignored));
  if (beside) {
    const fs::path written = target.string() + kUnfinished;
    return open_alone(written, path).map([&](int descriptor) { return OutputFile(target, written, descriptor); });
  }
  // What is open already may have something in it, from which this goes on.
  const int descriptor = ::open(target.c_str(), O_WRONLY | O_CLOEXEC | O_APPEND);
  if (descriptor < 0) return call_failed(path, errno, ErrorKind::kCannotWrite);
  return OutputFile(target, target, descriptor);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      written_path_(std::move(other.written_path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      failure_(other.failure_),
      buffer_(std::move(other.buffer_)) {}

OutputFile::~OutputFile() {
  if (descriptor_ < 0) return;
  if (is_beside()) ::unlink(written_path_.c_str());
  ::close(descriptor_);
}

void OutputFile::remember_failure() {
  if (failure_ == 0) failure_ = errno;
}

void OutputFile::write(std::string_view bytes) {
  if (buffer_.size() + bytes.size() > kBufferSize) flush();
  buffer_.append(bytes);
}

void OutputFile::flush() {
  if (failure_ == 0) failure_ = write_all(descriptor_, buffer_);
  buffer_.clear();
}

void OutputFile::write_out() {
  flush();
  if (failure_ == 0 && is_beside() && ::fsync(descriptor_) != 0) remember_failure();
}

Expected<void> OutputFile::outcome() const {
  if (failure_ == 0) return {};
  return call_failed(path_, failure_, ErrorKind::kCannotWrite);
}

Expected<void> OutputFile::sync() {
  write_out();
  return outcome();
}

Expected<void> OutputFile::commit() {
  write_out();
  return commit_unsynced();
}

Expected<void> OutputFile::commit_unsynced() {
  flush();
  // What closing would say, while the lock still holds the name.
  if (failure_ == 0 && ::close(::dup(descriptor_)) != 0) remember_failure();
  if (failure_ == 0 && is_beside() && std::rename(written_path_.c_str(), path_.c_str()) != 0) remember_failure();
  if (failure_ != 0 && is_beside()) ::unlink(written_path_.c_str());
  ::close(std::exchange(descriptor_, -1));
  return outcome();
}

Expected<void> write_file(const std::filesystem::path& path, std::string_view bytes) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  file->write(bytes);
  return file->commit();
}

Expected<void> write_file_unsynced(const std::filesystem::path& path, std::string_view bytes) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  file->write(bytes);
  return file->commit_unsynced();
}

}  // namespace mapjoin
