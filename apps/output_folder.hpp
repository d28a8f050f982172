// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A folder of results that gets all of its files, or none.

#include <filesystem>
#include <mapjoin/io/files/system_call.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// A folder whose files are written aside and take their places on commit(). Without commit() they are removed, as are the
/// folders that were made; what a killed process left aside is cleared by the next one. May fail() (see exit_code.hpp).
class OutputFolder {
 public:
  /// Makes the folder if it does not exist; on commit() its files replace those of the same names, one after the other.
  /// kCannotWrite if nothing can be written into it, or another process is writing it.
  explicit OutputFolder(const std::filesystem::path& path);
  /// A folder of files that mean something only together: it appears with all of them at once. kCannotWrite, too, if there is
  /// something in it.
  static OutputFolder whole(const std::filesystem::path& path);
  OutputFolder(OutputFolder&& other) = default;
  ~OutputFolder();

  /// The path at which to write the file `name` before commit().
  std::filesystem::path aside(const std::string& name) const { return aside_ / name; }
  /// The path of the file `name` after commit().
  std::filesystem::path file(const std::string& name) const { return path_ / name; }
  /// Moves the files of these names to their places; unless the folder is a whole one, other files among `former`, which an
  /// earlier process wrote there, are removed first. kCannotWrite.
  void commit(const std::vector<std::string>& names, const std::vector<std::string>& former = {});

 private:
  OutputFolder(std::filesystem::path path, std::filesystem::path aside, bool is_whole);
  void begin();
  void replace(const std::vector<std::string>& names, const std::vector<std::string>& former) const;
  void appear();

  std::filesystem::path path_;
  std::filesystem::path aside_;  ///< Folder of the files before commit(), within `path_` or beside it; empty once gone.
  std::vector<std::filesystem::path> made_;  ///< Folders that were made, innermost first.
  bool is_whole_ = false;
  Descriptor lock_;
};

/// The output folder of a command, made before its work; nullopt if the path is empty.
std::optional<OutputFolder> output_folder(const std::filesystem::path& path);

}  // namespace mapjoin::apps
