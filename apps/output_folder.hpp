// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A folder of results that gets all of its files, or none.

#include <filesystem>
#include <mapjoin/io/files/system_call.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// Files are written aside and take their places on commit(). Where that does not happen, they are removed, and so are the
/// folders that were made; what a process left aside that was killed, the next one clears. May fail() (see exit_code.hpp).
class OutputFolder {
 public:
  /// Makes the folder if it is not there; its files then replace those of their names, one after the other. Fails with
  /// kCannotWrite where nothing can be written into it, or where another process is writing it.
  explicit OutputFolder(const std::filesystem::path& path);
  /// For files that mean something only together: the folder appears with all of them at once. kCannotWrite, too, where there
  /// is something in it.
  static OutputFolder whole(const std::filesystem::path& path);
  OutputFolder(OutputFolder&& other) = default;
  ~OutputFolder();

  /// Where to write the file `name` until commit().
  std::filesystem::path aside(const std::string& name) const { return aside_ / name; }
  /// Where it will be.
  std::filesystem::path file(const std::string& name) const { return path_ / name; }
  /// The files of these names take their places; where the folder is not a whole one, the others of `former`, which an earlier
  /// process wrote there, are removed before. kCannotWrite.
  void commit(const std::vector<std::string>& names, const std::vector<std::string>& former = {});

 private:
  OutputFolder(std::filesystem::path path, std::filesystem::path aside, bool is_whole);
  void begin();
  void replace(const std::vector<std::string>& names, const std::vector<std::string>& former) const;
  void appear();

  std::filesystem::path path_;
  std::filesystem::path aside_;              ///< Within the folder, or beside it. Empty once it is gone.
  std::vector<std::filesystem::path> made_;  ///< Innermost first.
  bool is_whole_ = false;
  Descriptor lock_;
};

/// The folder that a command asks for, before its work; none where the path is empty.
std::optional<OutputFolder> output_folder(const std::filesystem::path& path);

}  // namespace mapjoin::apps
