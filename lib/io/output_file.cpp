// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <mapjoin/io/output_file.hpp>
#include <system_error>
#include <utility>

namespace mapjoin {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 18;

tl::unexpected<Error> cannot_write(const std::filesystem::path& path, int reason) {
  return tl::unexpected(
      Error{ErrorKind::kCannotWrite, fmt::format("{}: {}", path.string(), std::generic_category().message(reason))});
}

}  // namespace

OutputFile::OutputFile(std::filesystem::path path, std::filesystem::path written_path, int descriptor)
    : path_(std::move(path)), written_path_(std::move(written_path)), descriptor_(descriptor) {
  buffer_.reserve(kBufferSize);
}

Expected<OutputFile> OutputFile::create(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  std::error_code nameless;  // /dev/stdout leads to a pipe without a name.
  const fs::path resolved = fs::canonical(path, nameless);
  const fs::path target = nameless ? path : resolved;  // A link stays a link.
  const bool beside = !fs::exists(target, ignored) || fs::is_regular_file(target, ignored);
  fs::path written = target;
  if (beside) written += fmt::format(".tmp-{}", ::getpid());
  const int descriptor = ::open(written.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) return cannot_write(path, errno);
  return OutputFile(target, written, descriptor);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      written_path_(std::move(other.written_path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      failure_(other.failure_),
      buffer_(std::move(other.buffer_)) {}

OutputFile::~OutputFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  if (is_beside()) ::unlink(written_path_.c_str());
}

void OutputFile::remember_failure() {
  if (failure_ == 0) failure_ = errno;
}

void OutputFile::write(std::string_view bytes) {
  if (buffer_.size() + bytes.size() > kBufferSize) flush();
  buffer_.append(bytes);
}

void OutputFile::flush() {
  std::string_view rest = buffer_;
  while (!rest.empty() && failure_ == 0) {
    const ::ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written >= 0) {
      rest.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      remember_failure();
    }
  }
  buffer_.clear();
}

Expected<void> OutputFile::commit() {
  flush();
  if (failure_ == 0 && is_beside() && ::fsync(descriptor_) != 0) remember_failure();
  if (::close(std::exchange(descriptor_, -1)) != 0) remember_failure();
  if (failure_ == 0 && is_beside() && std::rename(written_path_.c_str(), path_.c_str()) != 0) remember_failure();
  if (failure_ == 0) return {};
  if (is_beside()) ::unlink(written_path_.c_str());
  return cannot_write(path_, failure_);
}

}  // namespace mapjoin
