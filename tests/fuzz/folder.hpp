// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A folder of several files out of one input.

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::fuzz {

/// Files by name.
using Files = std::map<std::string, std::string_view>;

/// Each file stands below a line `==> NAME <==`, as `tail -n +1 FILE…` prints them; the last one of a name counts, names that
/// are more than a name do not.
Files files_in(std::string_view bytes);

/// A folder that has the files of the last input, and no others.
class Folder {
 public:
  const std::filesystem::path& path() const { return folder_.path(); }
  void hold(const Files& files);

 private:
  testing::TemporaryFolder folder_;
};

}  // namespace mapjoin::fuzz
