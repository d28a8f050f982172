// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the operating system says of a call that failed, and what it takes to write a file safely.

#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <string_view>
#include <utility>

namespace mapjoin {

/// A file descriptor that closes itself; -1 for none.
class Descriptor {
 public:
  explicit Descriptor(int value = -1) : value_(value) {}
  /// Opens a file for reading; none, with errno, where that cannot be.
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

/// `path: ` and the errno `reason` in words; kInterrupted where it is EINTR, for a signal without SA_RESTART ends a call that
/// waits, else `kind`.
tl::unexpected<Error> call_failed(const std::filesystem::path& path, int reason, ErrorKind kind);

/// Writes all bytes to a file descriptor. The errno of the first failure, or 0.
int write_all(int descriptor, std::string_view bytes);

/// kCannotWrite of an output, for something else has the name that it needs until it is done.
tl::unexpected<Error> in_the_way(const std::filesystem::path& path, const std::filesystem::path& output);

/// A new descriptor for writing to `path`, which is made where it is not there, locked until the descriptor is closed, and
/// emptied: it is what a process left that was killed. To be renamed or removed before it is closed. kCannotWrite, about
/// `output`, where that cannot be, where another process has the file, or where something is in_the_way().
Expected<Descriptor> open_alone(const std::filesystem::path& path, const std::filesystem::path& output);

/// Whether the descriptor's file still has the name: it may have been renamed, removed or replaced.
bool has_name(int descriptor, const std::filesystem::path& path);

}  // namespace mapjoin
