// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The truth that a map is measured against, as a file gives it.

#include <filesystem>
#include <mapjoin/io/formats/trajectory.hpp>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin::apps {

/// Of each name its value, where the two lists have it.
template <typename Index, typename Id, typename Value>
Table<Index, std::optional<Value>> by_name(const Table<Index, Id>& ids, const Table<Index, Value>& values,
                                           const Table<Index, Id>& names) {
  Table<Index, std::optional<Value>> found(names.size());
  const IndexOf index_of(names);
  for (const Index index : indices(values)) {
    if (const auto at = index_of(ids[index])) found[*at] = values[index];
  }
  return found;
}

class TruthFile {
 public:
  /// `.tum`: a trajectory; else a log whose file gives values (a g2o file with vertices; edges do not count).
  static Expected<TruthFile> open(const std::filesystem::path& path);

  /// What it has of a map: by name; the poses of a trajectory by their time stamps, to the microsecond, or, where the map has
  /// none, by their count. kUsage where the dimensions differ.
  template <int Dim>
  Expected<Truth<Dim>> of(const GlobalMap<Dim>& map) const;

 private:
  using Content = std::variant<AnyLog, std::vector<StampedPose>>;
  TruthFile(std::string path, Content content) : path_(std::move(path)), content_(std::move(content)) {}

  std::string path_;
  Content content_;
};

}  // namespace mapjoin::apps
