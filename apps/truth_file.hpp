// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The truth that a map is measured against, as a file gives it.

#include <filesystem>
#include <mapjoin/io/formats/trajectory.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace mapjoin::apps {

/// The value of each of `names` that `ids` has, from `values`; nullopt for the others.
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

/// Times of one instant differ by no more (s).
inline constexpr double kSameTime = 1e-6;
/// Times of one pose in the trajectories of two tools differ by no more, unless the user says otherwise (s).
inline constexpr double kMatchingTimes = 0.01;

/// The poses by time stamp: for each the line of the trajectory that is nearest in time, if it is at most `most_apart` (s)
/// away. A line is where one robot was: kUsage, in a clause without the file, if another session is under way at its time.
template <int Dim>
Expected<Table<PoseIndex, std::optional<Pose<Dim>>>> by_time(const std::vector<StampedPose>& trajectory, const PoseIds& poses,
                                                             const Table<PoseIndex, std::int64_t>& stamps_ns,
                                                             double most_apart);

/// The truth in a file. All of it may fail() (see exit_code.hpp).
class TruthFile {
 public:
  /// Reads a trajectory of TUM's or KITTI's, or a log whose file gives values: g2o or TORO with vertices, the CSV table of a
  /// map, the folder of a run. Times match if they are at most `most_apart` (s) apart. Of the options `read` of the map count
  /// those that leave lines out or repair weights.
  explicit TruthFile(const std::filesystem::path& path, double most_apart = kSameTime, const ReadOptions& read = {});

  /// Counts the poses of a trajectory without times among those of a whole log from now on, even for the map of a part. kUsage
  /// if the log has no time stamps and the trajectory has times: a line that begins with more than a whole number.
  template <int Dim>
  void count_among(const Log<Dim>& whole) {
    if (whole.stamps_ns.empty()) demand_counts();
    counted_ = whole.poses;
  }
  /// Learns from the path of the map what its names say from now on. Those of a trajectory file are but counts: also in a truth
  /// with names its poses are found by time stamp or, if one of them has none, by count. Features that `--associate` named are
  /// left out, as by leave_features_out().
  void take_map(const std::filesystem::path& map);
  /// Compares no features from now on: `--associate` named those of the map, as those of no other map.
  void leave_features_out() { takes_features_ = false; }
  /// True if the truth is a log in space.
  bool is_in_space() const;
  /// True if the truth has features that are not compared: `--associate` named them, or those of the map.
  bool leaves_features_out() const { return has_features() && !takes_features_; }
  /// True if the truth has features, which are compared.
  bool compares_features() const { return has_features() && takes_features_; }

  /// The truth of a map or of a log with these names: by name or, for the poses of a trajectory, by time stamp or, if it or the
  /// map has none, by count. kUsage if the dimensions differ, and as for by_time() and count_among().
  template <int Dim>
  Truth<Dim> of(const PoseIds& poses, const FeatureIds& features, const Table<PoseIndex, std::int64_t>& stamps_ns) const;
  template <int Dim>
  Truth<Dim> of(const GlobalMap<Dim>& map) const {
    return of<Dim>(map.pose_ids, map.feature_ids, map.stamps_ns);
  }
  template <int Dim>
  Truth<Dim> of(const Log<Dim>& log) const {
    return of<Dim>(log.poses, log.features, log.stamps_ns);
  }
  /// The pairs of these poses that edges of the truth tie; none for a trajectory if the truth has time stamps.
  std::vector<std::pair<PoseIndex, PoseIndex>> relations(const PoseIds& poses) const;

 private:
  bool has_features() const;
  void demand_counts() const;
  /// The poses that were found by time; fails with what by_time() says, and the remedy.
  template <typename Found>
  Found told(Expected<Found> found, const char* remedy) const;
  template <int Dim>
  Table<PoseIndex, std::optional<Pose<Dim>>> poses_in(const Log<Dim>& truth, const PoseIds& poses,
                                                      const Table<PoseIndex, std::int64_t>& stamps_ns) const;

  std::string path_;
  double most_apart_;
  std::variant<AnyLog, std::vector<StampedPose>> content_;
  bool has_times_ = false;          ///< True for a trajectory whose lines begin with more than a count.
  bool is_map_trajectory_ = false;  ///< Set by take_map().
  bool takes_features_ = true;      ///< False if names of features are those of `--associate`.
  bool may_count_ = true;           ///< False for a trajectory with a line that begins with no count.
  PoseIds counted_;                 ///< Set by count_among().
};

}  // namespace mapjoin::apps
