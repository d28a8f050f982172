// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Errors of system calls in words, and the calls that writing a file safely takes.

#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <string_view>
#include <utility>

namespace mapjoin {

/// A file descriptor that closes itself; -1 for none.
class Descriptor {
 public:
  explicit Descriptor(int value = -1) : value_(value) {}
  /// Opens a file for reading; none, with errno set, if it cannot be opened.
  static Descriptor to_read(const std::filesystem::path& path);
  Descriptor(Descriptor&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(value_, other.value_);
    return *this;
  }
  ~Descriptor();
  int value() const { return value_; }
  bool is_open() const { return value_ >= 0; }

 private:
  int value_;
};

/// The error `path: ` and the errno `reason` in words; kInterrupted if `reason` is EINTR, since a signal without SA_RESTART
/// ends a call that waits, otherwise `kind`.
tl::unexpected<Error> call_failed(const std::filesystem::path& path, int reason, ErrorKind kind);

/// Writes all bytes to a file descriptor; the errno of the first failure, or 0.
int write_all(int descriptor, std::string_view bytes);

/// The error kCannotWrite for `output`: something else has the name `path`, which the output needs until it is done.
tl::unexpected<Error> in_the_way(const std::filesystem::path& path, const std::filesystem::path& output);

/// A new descriptor for writing to `path`, created if missing, locked until it is closed, and emptied: a file found there is
/// what a killed process left. Rename or remove the file before closing it. kCannotWrite, about `output`, if the file cannot be
/// opened, if another process has it, or if something is in_the_way().
Expected<Descriptor> open_alone(const std::filesystem::path& path, const std::filesystem::path& output);

/// True if the descriptor's file still has the name, that is, was not renamed, removed or replaced.
bool has_name(int descriptor, const std::filesystem::path& path);

}  // namespace mapjoin
