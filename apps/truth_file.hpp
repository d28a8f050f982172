// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The truth that a map is measured against, as a file gives it.

#include <filesystem>
#include <mapjoin/io/formats/trajectory.hpp>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string>
#include <utility>
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

/// What is read and asked of it may fail() (see exit_code.hpp).
class TruthFile {
 public:
  /// A trajectory of TUM's or KITTI's; or a log whose file gives values: g2o or TORO with vertices, the CSV table of a map.
  /// Times may be so far apart (s).
  explicit TruthFile(const std::filesystem::path& path, double most_apart = 1e-6);

  /// Poses without time stamps are from now on counted among these, those of a whole log, though it be for the map of a part.
  /// kUsage of a trajectory that has times with fractions of seconds.
  void count_among(const PoseIds& poses);
  /// What it has of a map, or of a log, with these names: by name; the poses of a trajectory by their time stamps or, where
  /// there are none, by their count. kUsage where the dimensions differ, and as of count_among().
  template <int Dim>
  Truth<Dim> of(const PoseIds& poses, const FeatureIds& features, const Table<PoseIndex, std::int64_t>& stamps_ns) const;
  template <int Dim>
  Truth<Dim> of(const GlobalMap<Dim>& map) const {
    return of<Dim>(map.pose_ids, map.feature_ids, map.stamps_ns);
  }
  /// The pairs of these poses that its edges tie.
  std::vector<std::pair<PoseIndex, PoseIndex>> relations(const PoseIds& poses) const;

 private:
  void demand_counts() const;

  std::string path_;
  double most_apart_;
  std::variant<AnyLog, std::vector<StampedPose>> content_;
  PoseIds counted_;  ///< By count_among().
};

}  // namespace mapjoin::apps
