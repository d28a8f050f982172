// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// An output file that appears whole under its name, or not at all.

#include <filesystem>
#include <mapjoin/io/files/system_call.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// The suffix of the name of an unfinished file or folder; the writer of the finished one clears what has it.
inline constexpr const char* kUnfinished = ".mapjoin-tmp";

/// The path to which the links from `path` lead, existing or not; links to open files (/dev/stdout) are not followed.
std::filesystem::path link_target(std::filesystem::path path);
/// The absolute path to which links and dots lead from `path`; empty if it cannot be determined.
std::filesystem::path destination(const std::filesystem::path& path);
/// True if both paths lead to the same file, existing or not; false for devices, pipes, folders and empty paths.
bool are_one_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// Gives a file or folder the permissions of the one that it is to replace, if there is one and the file system has any; its
/// owner may write it, as a next call does that clears what this one left.
void take_permissions_of(const std::filesystem::path& replaced, const std::filesystem::path& path);

/// An output file. Bytes go to `name.mapjoin-tmp` beside it, which takes the name on commit() and is otherwise removed; the
/// next writer of the file clears what a killed process left there. Devices, pipes and open files (/dev/stdout, behind their
/// content) are written to directly. A link stays a link. A file that is replaced hands on its permissions, to which the
/// owner's to write it is added. Buffered.
class OutputFile {
 public:
  /// Opens an output file; kCannotWrite if it cannot be made or another process is writing it.
  static Expected<OutputFile> create(const std::filesystem::path& path);
  OutputFile(OutputFile&& other) = default;
  ~OutputFile();

  /// Appends bytes; does nothing after a write has failed, which commit() reports.
  void write(std::string_view bytes);
  /// Puts everything so far on the disk, so that commit() is all but certain; errors as of commit().
  Expected<void> sync();
  /// Puts everything on the disk and the file under its name; to be called once. kCannotWrite, with the path and the reason of
  /// the first failure; kInterrupted if a signal ended the wait for a pipe.
  Expected<void> commit();
  /// As commit(), without waiting for the disk: for one of many files that appear together in a folder of their own.
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

/// Writes a whole file at once, the second function without waiting for the disk; kCannotWrite.
Expected<void> write_file(const std::filesystem::path& path, std::string_view bytes);
Expected<void> write_file_unsynced(const std::filesystem::path& path, std::string_view bytes);

}  // namespace mapjoin
