// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A folder of results that gets all of its files, or none.

#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// Files are written aside, in a folder within the folder, and take their places on commit(). Where that does not happen, they
/// are removed, and so are the folders that were made.
class OutputFolder {
 public:
  /// Makes the folder if it is not there. kCannotWrite where nothing can be written into it.
  static Expected<OutputFolder> create(const std::filesystem::path& path);
  OutputFolder(OutputFolder&& other) noexcept;
  OutputFolder& operator=(OutputFolder&&) = delete;
  ~OutputFolder();

  /// Where to write the file `name` until commit().
  std::filesystem::path aside(const std::string& name) const { return aside_ / name; }
  /// Where it will be.
  std::filesystem::path file(const std::string& name) const { return path_ / name; }
  Expected<void> commit(const std::vector<std::string>& names);

 private:
  OutputFolder() = default;

  std::filesystem::path path_;
  std::filesystem::path aside_;              ///< Empty once moved from.
  std::vector<std::filesystem::path> made_;  ///< Innermost first.
};

/// The folder that a call asks for, before its work; none where the path is empty. As OutputFolder::create().
Expected<std::optional<OutputFolder>> output_folder(const std::filesystem::path& path);

}  // namespace mapjoin::apps
