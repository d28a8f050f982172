// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The names that poses and features had in a log, for its map as it is read from a file, which may have others for them.

#include <filesystem>
#include <mapjoin/io/g2o/numbering.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/ids.hpp>
#include <optional>

namespace mapjoin::apps {

/// Bad input: a file that tells of another map than the one it lies beside.
[[noreturn]] void fail_not_of_map(const std::filesystem::path& file);

/// Finds the poses and features of a map by their names in its log. A g2o file has one numbering of all, and so other names for
/// poses of further sessions and for features; other files of maps have the same.
class LogNames {
 public:
  /// `file`, which lies beside the map, says as `told` how all poses and features are named and where they are. Bad input where
  /// they are others, or elsewhere, in the map; features of a map without any are not looked for.
  template <int Dim>
  LogNames(const std::filesystem::path& file, const GlobalMap<Dim>& told, const GlobalMap<Dim>& map);
  /// By `poses.csv` and `features.csv` in the folder of a run, for its `map`.
  template <int Dim>
  static LogNames of_run(const std::filesystem::path& folder, const GlobalMap<Dim>& map);

  /// Nothing where the log has no such name.
  std::optional<PoseIndex> operator()(const PoseId& id) const;
  std::optional<FeatureIndex> operator()(const FeatureId& id) const;

 private:
  G2oNumbering numbering_;
  IndexOf<PoseIndex, PoseId> poses_;
  IndexOf<FeatureIndex, FeatureId> features_;
};

}  // namespace mapjoin::apps
