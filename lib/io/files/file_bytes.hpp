// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The bytes of an input file, gzip undone: mapped where the file is plain, else held in memory.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <memory>
#include <string>
#include <string_view>

namespace mapjoin {

/// More than any text log needs; a gzip file or pipe that gives more is refused.
inline constexpr std::size_t kMostUnpackedBytes = std::size_t{1} << 32;

/// How a deflated stream is wrapped.
enum class Wrapping : std::uint8_t { kZlib, kGzip };
enum class Inflated : std::uint8_t { kWhole, kCutOff, kDamaged, kTooLarge };

/// Appends what the stream at the begin of `packed` holds to `bytes`, which may then be of `most`, and takes the stream off
/// `packed`. Its checksum is verified.
Inflated append_inflated(Wrapping wrapping, std::string_view& packed, std::size_t most, std::string& bytes);

/// Owns the bytes that view() shows; a value that may be copied.
class FileBytes {
 public:
  /// Bad input, in one sentence beginning with the path: a file that is missing, a directory, unreadable, empty, or a damaged
  /// or cut-off gzip stream. kTooLarge where more than `most_unpacked` bytes come out of a gzip stream or a pipe. Gzip is known
  /// by its first two bytes; several members in a row are one stream, zeros behind it do not count. kInterrupted where a signal
  /// ends the wait for a pipe.
  static Expected<FileBytes> read(const std::filesystem::path& path, std::size_t most_unpacked = kMostUnpackedBytes);

  std::string_view view() const { return view_; }

 private:
  FileBytes(std::shared_ptr<const void> owner, std::string_view view) : owner_(std::move(owner)), view_(view) {}
  static FileBytes of(std::string bytes);

  std::shared_ptr<const void> owner_;
  std::string_view view_;
};

}  // namespace mapjoin
