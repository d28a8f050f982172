// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The permissions of files that replace others.

#include <sys/stat.h>

#include <filesystem>

namespace mapjoin {

/// Gives a file the permissions of the one that it is to replace, if there is one and the file system has any; its owner may
/// write it, as a next call does that clears what this one left.
inline void take_mode_of(const std::filesystem::path& replaced, const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(replaced.c_str(), &status) == 0) (void)::chmod(file.c_str(), (status.st_mode & 0777) | S_IWUSR);
}

}  // namespace mapjoin
