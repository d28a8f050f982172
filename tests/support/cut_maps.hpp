// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A set of local maps cut into sessions, each a folder of maps that are counted from 1.

#include <filesystem>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace mapjoin::testing {

/// Writes each session to a folder of its own below `folder`, and returns these folders.
inline std::vector<std::filesystem::path> cut_maps(const SubmapSet<2>& set, std::size_t sessions,
                                                   const std::filesystem::path& folder) {
  const auto& maps = set.graph.submaps;
  std::vector<std::filesystem::path> folders;
  for (std::size_t k = 0; k < sessions; ++k) {
    folders.push_back(folder / std::to_string(k));
    std::filesystem::create_directory(folders.back());
    const auto place = [&](std::size_t session) {
      return maps.begin() + static_cast<std::ptrdiff_t>(session * maps.size() / sessions);
    };
    const auto written = write_local_maps<2>({place(k), place(k + 1)}, set.features, LocalMapFormat::kText, folders.back());
    if (!written) throw std::runtime_error(written.error().message);
  }
  return folders;
}

}  // namespace mapjoin::testing
