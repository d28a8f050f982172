// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The bytes of an input file, gzip undone: mapped if the file is plain, otherwise held in memory.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <memory>
#include <string>
#include <string_view>

namespace mapjoin {

/// The most bytes taken from a gzip file or pipe, more than any text log needs.
inline constexpr std::size_t kMostUnpackedBytes = std::size_t{1} << 32;

/// The wrapping of a deflated stream.
enum class Wrapping : std::uint8_t { kZlib, kGzip };
enum class Inflated : std::uint8_t { kWhole, kCutOff, kDamaged, kTooLarge };

/// Appends the inflated content of the stream at the start of `packed` to `bytes`, up to `most` bytes in all, and takes the
/// stream off `packed`. Its checksum is verified.
Inflated append_inflated(Wrapping wrapping, std::string_view& packed, std::size_t most, std::string& bytes);

/// The bytes of a file, which view() shows; copies share them.
class FileBytes {
 public:
  /// Reads a file. Gzip is known by its first two bytes; several members in a row are one stream, and zeros behind it are
  /// passed over. Bad input, in one sentence that begins with the path: a file that is missing, a directory, unreadable or
  /// empty, or a gzip stream that is damaged or cut off. kTooLarge if a gzip stream or a pipe gives more than `most_unpacked`
  /// bytes; kInterrupted if a signal ends the wait for a pipe.
  static Expected<FileBytes> read(const std::filesystem::path& path, std::size_t most_unpacked = kMostUnpackedBytes);

  /// The content of the file `path` inside another one, such as a member of an archive, gzip undone as by read(). Plain
  /// content is not copied, and must outlive it.
  static Expected<FileBytes> of_member(const std::filesystem::path& path, std::string_view content,
                                       std::size_t most_unpacked = kMostUnpackedBytes);

  std::string_view view() const { return view_; }

 private:
  FileBytes(std::shared_ptr<const void> owner, std::string_view view) : owner_(std::move(owner)), view_(view) {}
  static FileBytes of(std::string bytes);

  std::shared_ptr<const void> owner_;
  std::string_view view_;
};

}  // namespace mapjoin
