// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Folders of several files, made of one input.

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::fuzz {

/// Files by name.
using Files = std::map<std::string, std::string_view>;

/// The files in an input, each below a line `==> NAME <==`, as `tail -n +1 FILE…` prints them. The last file of a name counts;
/// files whose name could be a path are left out.
Files files_in(std::string_view bytes);

/// A folder that holds the files of the last input, and no others.
class Folder {
 public:
  const std::filesystem::path& path() const { return folder_.path(); }
  void hold(const Files& files);

 private:
  testing::TemporaryFolder folder_;
};

}  // namespace mapjoin::fuzz
