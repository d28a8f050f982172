// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// An output file that appears whole under its name, or not at all.

#include <filesystem>
#include <mapjoin/io/files/system_call.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// What ends the name of a file or folder that is not finished; it is cleared by what writes the finished one.
inline constexpr const char* kUnfinished = ".mapjoin-tmp";

/// Where links lead from `path`, also where nothing is yet; not through open files (/dev/stdout).
std::filesystem::path link_target(std::filesystem::path path);

/// Bytes go to `name.mapjoin-tmp` beside the file, which takes the name on commit() and is removed where that does not happen;
/// the next to write the file clears what a process left there that was killed. What is there and is not a regular file (a
/// device, a pipe) is written to directly, and so is what is open already (/dev/stdout), behind what is in it. A link stays a
/// link. Buffered.
class OutputFile {
 public:
  /// kCannotWrite where the file cannot be made, or where another process is writing it.
  static Expected<OutputFile> create(const std::filesystem::path& path);
  OutputFile(OutputFile&& other) = default;
  ~OutputFile();

  /// After a write has failed, further ones do nothing: commit() reports the failure.
  void write(std::string_view bytes);
  /// Everything so far on the disk, for commit() to be all but certain; else as commit().
  Expected<void> sync();
  /// Everything on the disk and the file under its name; else kCannotWrite, with the first failure's path and reason, or
  /// kInterrupted where a signal ended the wait for a pipe. Once.
  Expected<void> commit();
  /// The same without waiting for the disk: for one of many files, which a folder of their own makes appear together.
  Expected<void> commit_unsynced();

 private:
  OutputFile(std::filesystem::path path, std::filesystem::path written_path, Descriptor descriptor);
  void flush();
  Expected<void> outcome() const;
  bool is_beside() const { return written_path_ != path_; }

  std::filesystem::path path_;
  std::filesystem::path written_path_;
  Descriptor descriptor_;
  int failure_ = 0;  ///< The first errno, or 0.
  std::string buffer_;
};

/// All of a file at once; kCannotWrite.
Expected<void> write_file(const std::filesystem::path& path, std::string_view bytes);
Expected<void> write_file_unsynced(const std::filesystem::path& path, std::string_view bytes);

}  // namespace mapjoin
