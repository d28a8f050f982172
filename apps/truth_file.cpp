// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/exit_code.hpp>
#include <apps/extra_files.hpp>
#include <apps/outputs.hpp>
#include <apps/truth_file.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/io/run_folder.hpp>

namespace mapjoin::apps {
namespace {

/// The pose in `Dim` dimensions; in the plane with its turn about z.
template <int Dim>
Pose<Dim> in_dimension(const Pose<3>& pose) {
  if constexpr (Dim == 3) {
    return pose;
  } else {
    const Eigen::Quaterniond& q = pose.rotation.quaternion();
    return {pose.translation.head<2>(), Rotation<2>(2.0 * std::atan2(q.z(), q.w()))};
  }
}

/// The poses by count: the times of the trajectory are indices into `counted`.
template <int Dim>
Table<PoseIndex, std::optional<Pose<Dim>>> by_count(const std::vector<StampedPose>& trajectory, const PoseIds& counted,
                                                    const PoseIds& poses) {
  PoseIds ids;
  Table<PoseIndex, Pose<Dim>> values;
  for (const StampedPose& line : trajectory) {
    if (line.time < 0.0 || line.time >= static_cast<double>(counted.size())) continue;
    ids.push_back(counted[PoseIndex(static_cast<std::size_t>(line.time))]);
    values.push_back(in_dimension<Dim>(line.pose));
  }
  return by_name(ids, values, poses);
}

using TimedLines = std::map<double, const StampedPose*>;

/// The line of the nearest time; nullptr if none is near enough (s).
const StampedPose* nearest_line(const TimedLines& lines, double time, double most_apart) {
  const auto apart = [&](const auto& line) { return std::abs(line.first - time); };
  auto nearest = lines.lower_bound(time);
  if (nearest == lines.end() || (nearest != lines.begin() && apart(*std::prev(nearest)) <= apart(*nearest))) {
    if (nearest == lines.begin()) return nullptr;
    --nearest;
  }
  return apart(*nearest) <= most_apart ? nearest->second : nullptr;
}

/// The times of a session's first and last pose (s).
struct TimeSpan {
  double first = std::numeric_limits<double>::infinity();
  double last = -first;

  bool is_under_way(double time) const { return first + kSameTime < time && time < last - kSameTime; }
};

std::map<std::uint32_t, TimeSpan> spans_of(const PoseIds& poses, const Table<PoseIndex, std::int64_t>& stamps_ns) {
  std::map<std::uint32_t, TimeSpan> spans;
  for (const PoseIndex p : indices(stamps_ns)) {
    TimeSpan& span = spans[poses[p].session];
    span.first = std::min(span.first, in_seconds(stamps_ns[p]));
    span.last = std::max(span.last, in_seconds(stamps_ns[p]));
  }
  return spans;
}

/// The trajectory of a KITTI log, with the counts of its poses as times.
std::vector<StampedPose> counted(const AnyLog& log) {
  std::vector<StampedPose> trajectory;
  std::visit(
      [&](const auto& any) {
        for (const auto& pose : any.initial.poses)
          trajectory.push_back({static_cast<double>(trajectory.size()), in_space(pose)});
      },
      log);
  return trajectory;
}

/// The log; fails if it does not give the values of its poses.
AnyLog with_values(AnyLog log, const std::string& path) {
  const bool has_values = std::visit([](const auto& any) { return !any.initial.poses.empty(); }, log);
  if (!has_values)
    fail(ErrorKind::kBadInput, path +
                                   ": as a truth it would have to give the values of its poses; `mapjoin run TRUTH -o FOLDER` "
                                   "makes a map of it, which does");
  return log;
}

/// The options of a map for reading its truth, whose format and conventions of weights are its own.
ReadOptions for_truth(ReadOptions of_map) {
  of_map.from = {};
  of_map.pose_error = {};
  of_map.rotation_information = {};
  return of_map;
}

/// The names that a trajectory has for so many poses.
PoseIds counts(std::size_t poses) {
  PoseIds names;
  for (std::size_t k = 0; k < poses; ++k) names.push_back({0, k});
  return names;
}

/// Where it says of which session a pose is, if a trajectory does not.
constexpr const char* kSessionsByTable =
    "a table like poses.csv does, by its column session, and `mapjoin error` measures the trajectory_K.tum of one session";

tl::unexpected<Error> both_under_way(std::uint32_t session, std::uint32_t other, double time) {
  return tl::unexpected(
      Error{ErrorKind::kUsage,
            fmt::format("sessions {} and {} are both under way at {:.3f} s, and a trajectory does not say of which it is",
                        session, other, time)});
}

/// True for a file with a trajectory of TUM's or KITTI's, whose poses have no names. False for a pipe, which can be read only
/// once.
bool is_trajectory_file(const std::filesystem::path& path) {
  std::error_code ignored;
  const auto bytes = std::filesystem::is_regular_file(path, ignored) ? FileBytes::read(path) : bad_input("");
  if (!bytes) return false;
  const TextScanner text(path.string(), bytes->view());
  return is_tum_line(text) || is_kitti_line(text);
}

/// True if every line begins with a whole number without a point, as counts do: write_tum() writes times with one.
bool begins_with_counts(TextScanner text) {
  const auto is_digit = [](char c) { return '0' <= c && c <= '9'; };
  while (text.next_line()) {
    if (!std::ranges::all_of(text.word(), is_digit)) return false;
  }
  return true;
}

/// Fails where two lines of the map's trajectory are of one time: which of them is meant is not known.
void demand_one_session(const std::string& truth, const Table<PoseIndex, std::int64_t>& stamps_ns) {
  std::vector<std::int64_t> times(stamps_ns.begin(), stamps_ns.end());
  std::ranges::sort(times);
  const auto twice = std::ranges::adjacent_find(times);
  if (twice == times.end()) return;
  fail(ErrorKind::kUsage, fmt::format("{}: the trajectory of the map has two lines of {:.3f} s; keep one or, if they are of "
                                      "two sessions, give the folder of the run in place of its trajectory",
                                      truth, in_seconds(*twice)));
}

}  // namespace

template <int Dim>
Expected<Table<PoseIndex, std::optional<Pose<Dim>>>> by_time(const std::vector<StampedPose>& trajectory, const PoseIds& poses,
                                                             const Table<PoseIndex, std::int64_t>& stamps_ns,
                                                             double most_apart) {
  Table<PoseIndex, std::optional<Pose<Dim>>> found(stamps_ns.size());
  const auto spans = spans_of(poses, stamps_ns);
  TimedLines lines;
  for (const StampedPose& line : trajectory) lines.emplace(line.time, &line);
  for (const PoseIndex p : indices(found)) {
    const StampedPose* const line = nearest_line(lines, in_seconds(stamps_ns[p]), most_apart);
    if (!line) continue;
    const auto other = std::ranges::find_if(
        spans, [&](const auto& span) { return span.first != poses[p].session && span.second.is_under_way(line->time); });
    if (other != spans.end()) return both_under_way(poses[p].session, other->first, line->time);
    found[p] = in_dimension<Dim>(line->pose);
  }
  return found;
}

TruthFile::TruthFile(const std::filesystem::path& path, double most_apart, const ReadOptions& read)
    : path_(path.string()), most_apart_(most_apart), takes_features_(!has_extra_file(Extra::kAssociations, path)) {
  const ReadOptions options = for_truth(read);
  if (is_run_folder(path)) {
    content_ = with_values(open_log(path, options).value(), path_);
    return;
  }
  const FileBytes bytes = FileBytes::read(path).value();
  const TextScanner text(path_, bytes.view());
  if (extension_of(path) == ".tum" || is_tum_line(text)) {
    has_times_ = !counts_poses(text);
    may_count_ = begins_with_counts(text);
    content_ = read_tum(text).value();
    return;
  }
  if (is_kitti_line(text)) {
    content_ = counted(read_kitti_log(text, options).value());
    return;
  }
  content_ = with_values(mapjoin::read_log(bytes.view(), path_, options).value(), path_);
}

void TruthFile::take_map(const std::filesystem::path& map) {
  is_map_trajectory_ = is_trajectory_file(map);
  if (has_extra_file(Extra::kAssociations, map)) leave_features_out();
}

bool TruthFile::is_in_space() const {
  const auto* log = std::get_if<AnyLog>(&content_);
  return log && std::holds_alternative<Log<3>>(*log);
}

bool TruthFile::has_features() const {
  const auto* log = std::get_if<AnyLog>(&content_);
  return log && std::visit([](const auto& any) { return !any.initial.features.empty(); }, *log);
}

void TruthFile::demand_counts() const {
  if (may_count_) return;
  fail(ErrorKind::kUsage,
       fmt::format("{}: has times, and the poses of the map have none; {}", path_,
                   is_map_trajectory_ ? "a TUM file or a table with times has them"
                                      : "`mapjoin run LOG --stamps FILE` gives them, and its folder keeps them"));
}

template <typename Found>
Found TruthFile::told(Expected<Found> found, const char* remedy) const {
  if (found) return *std::move(found);
  fail(found.error().kind, fmt::format("{}: {}; {}", path_, found.error().message, remedy));
}

template <int Dim>
Table<PoseIndex, std::optional<Pose<Dim>>> TruthFile::poses_in(const Log<Dim>& truth, const PoseIds& poses,
                                                               const Table<PoseIndex, std::int64_t>& stamps_ns) const {
  if (!is_map_trajectory_) return by_name(truth.poses, truth.initial.poses, poses);
  if (stamps_ns.empty() || truth.stamps_ns.empty()) {
    if (!stamps_ns.empty() && truth.poses.size() != poses.size()) {
      fail(ErrorKind::kUsage, fmt::format("{}: has no times by which to find the {} of the map among its {}; a TUM file or a "
                                          "table with times has them",
                                          path_, plural(poses.size(), "pose"), truth.poses.size()));
    }
    return by_name(counts(truth.poses.size()), truth.initial.poses, poses);
  }
  std::vector<StampedPose> lines, of_map;
  for (const PoseIndex p : indices(truth.stamps_ns)) {
    lines.push_back({in_seconds(truth.stamps_ns[p]), in_space(truth.initial.poses[p])});
  }
  for (const std::int64_t stamp : stamps_ns) of_map.push_back({in_seconds(stamp), {}});
  // The map has to be of one session of the truth at any time.
  demand_one_session(path_, stamps_ns);
  told(by_time<Dim>(of_map, truth.poses, truth.stamps_ns, most_apart_),
       "the folder of the run, in place of its trajectory, does");
  return told(by_time<Dim>(lines, poses, stamps_ns, most_apart_), kSessionsByTable);
}

template <int Dim>
Truth<Dim> TruthFile::of(const PoseIds& poses, const FeatureIds& features,
                         const Table<PoseIndex, std::int64_t>& stamps_ns) const {
  const Table<FeatureIndex, std::optional<Point<Dim>>> no_features(features.size());
  if (const auto* trajectory = std::get_if<std::vector<StampedPose>>(&content_)) {
    if (has_times_ && !stamps_ns.empty()) {
      if (is_map_trajectory_) demand_one_session(path_, stamps_ns);
      return {told(by_time<Dim>(*trajectory, poses, stamps_ns, most_apart_), kSessionsByTable), no_features};
    }
    demand_counts();
    return {by_count<Dim>(*trajectory, counted_.empty() ? poses : counted_, poses), no_features};
  }
  const auto* log = std::get_if<Log<Dim>>(&std::get<AnyLog>(content_));
  if (!log) {
    fail(ErrorKind::kUsage,
         fmt::format("{}: the truth is not in {}D, as the map is; a trajectory of it (`mapjoin convert TRUTH "
                     "TRUTH.tum`) is taken in either dimension",
                     path_, Dim));
  }
  return {poses_in(*log, poses, stamps_ns),
          takes_features_ ? by_name(log->features, log->initial.features, features) : no_features};
}

std::vector<std::pair<PoseIndex, PoseIndex>> TruthFile::relations(const PoseIds& poses) const {
  std::vector<std::pair<PoseIndex, PoseIndex>> pairs;
  if (const auto* log = std::get_if<AnyLog>(&content_)) {
    const IndexOf index_of(poses);
    const auto add = [&](const auto& any) {
      if (is_map_trajectory_ && !any.stamps_ns.empty()) return;
      const PoseIds names = is_map_trajectory_ ? counts(any.poses.size()) : any.poses;
      for (const auto& edge : any.edges()) {
        const auto base = index_of(names[edge.base]);
        const auto target = index_of(names[edge.target]);
        if (base && target) pairs.emplace_back(*base, *target);
      }
    };
    std::visit(add, *log);
  }
  return pairs;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                              \
  template Expected<Table<PoseIndex, std::optional<Pose<Dim>>>> by_time<Dim>(const std::vector<StampedPose>&, const PoseIds&, \
                                                                             const Table<PoseIndex, std::int64_t>&, double);  \
  template Truth<Dim> TruthFile::of(const PoseIds&, const FeatureIds&, const Table<PoseIndex, std::int64_t>&) const;
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
