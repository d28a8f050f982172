// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/formats/angle_text.hpp>
#include <mapjoin/io/formats/covariance_text.hpp>
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/formats/mat_log.hpp>
#include <mapjoin/io/formats/pose_tables.hpp>
#include <mapjoin/io/formats/skipped_lines.hpp>
#include <mapjoin/io/formats/trajectory.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/g2o/numbering.hpp>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;

/// The data that a format has a place for.
struct Room {
  bool edges = true;
  bool observations = true;
  bool priors = false;
  bool pose_values = false;
  bool feature_values = false;
  bool fixed = false;
  bool stamps = false;
  bool names = true;
  bool one_numbering = false;  ///< True if poses and features share one numbering.
  Weights weights = Weights::kExact;
};

/// All that the library knows of a format. A new one is a row of the table below.
struct Format {
  std::string_view extension;
  bool (*is)(std::string_view bytes);  ///< True if the content is in this format.
  Expected<AnyLog> (*read)(std::string_view bytes, const std::string& file, const ReadOptions& options);
  Expected<void> (*write_plane)(const Log<2>& log, const fs::path& path) = nullptr;
  Expected<void> (*write_space)(const Log<3>& log, const fs::path& path) = nullptr;  ///< Null if the format is for the plane.
  Room room = {};
};

/// True if the first line of a text begins with a tag that `is_tag` knows.
template <bool (*is_tag)(std::string_view)>
bool begins(std::string_view bytes) {
  TextScanner text("", bytes);
  return text.next_line() && is_tag(text.word());
}
/// True if the first line of a text is one that `is_line` knows.
template <bool (*is_line)(TextScanner)>
bool begins(std::string_view bytes) {
  return is_line(TextScanner("", bytes));
}
template <Expected<AnyLog> (*read)(TextScanner, const ReadOptions&)>
Expected<AnyLog> read_text(std::string_view bytes, const std::string& file, const ReadOptions& options) {
  return read(TextScanner(file, bytes), options);
}

Expected<AnyLog> read_g2o_text(std::string_view bytes, const std::string& file, const ReadOptions& options) {
  return read_g2o(TextScanner(file, bytes), options);
}

/// True for the tags that only TORO's files have.
bool is_toro_tag(std::string_view tag) {
  return tag == kToroPlane.pose_tag || tag == kToroSpace.pose_tag || kToroPlane.is_passed_over(tag);
}
bool is_gtsam_odometry(std::string_view tag) {
  return tag == kGtsamText.edge_tag;
}
bool is_isam_tag(std::string_view tag) {
  return kIsamPlane.has_tag(tag) || kIsamSpace.has_tag(tag);
}

/// True if a text begins with a format's own tag or with one of iSAM's, and has an own tag in any line.
template <bool (*is_own)(std::string_view)>
bool begins_like_isam(std::string_view bytes) {
  if (!begins<is_own>(bytes) && !begins<is_isam_tag>(bytes)) return false;
  for (TextScanner text("", bytes); text.next_line();) {
    if (is_own(text.word())) return true;
  }
  return false;
}

template <const EdgeText<2>& plane, const EdgeText<3>* space>
Expected<AnyLog> read_edges(TextScanner text, const ReadOptions& options) {
  return read_edge_text(std::move(text), plane, space, options);
}

template <int Dim>
GlobalMap<Dim> values_of(const Log<Dim>& log) {
  GlobalMap<Dim> map;
  map.pose_ids = log.poses;
  map.poses = log.initial.poses;
  map.stamps_ns = log.stamps_ns;
  return map;
}
template <int Dim, Expected<void> (*write)(const GlobalMap<Dim>&, const fs::path&)>
Expected<void> write_values(const Log<Dim>& log, const fs::path& path) {
  return write(values_of(log), path);
}

template <int Dim, const EdgeText<Dim>& format>
Expected<void> write_edges(const Log<Dim>& log, const fs::path& path) {
  return write_edge_text(log, format, path);
}

/// The row of a text of edges, which is read as the format says unless another reader is given.
template <const EdgeText<2>& plane, const EdgeText<3>* space>
Format edges_row(std::string_view extension, bool (*is)(std::string_view), decltype(Format::write_space) write_space,
                 decltype(Format::read) read = read_text<read_edges<plane, space>>) {
  Format row{extension, is, read, write_edges<2, plane>, write_space};
  row.room.observations = !plane.observation_tag.empty();
  row.room.pose_values = !plane.pose_tag.empty();
  row.room.one_numbering = plane.one_numbering;
  row.room.weights = plane.weights;
  return row;
}

constexpr Room kTrajectory{.edges = false, .observations = false, .pose_values = true, .names = false};
constexpr Room kStampedTrajectory{.edges = false, .observations = false, .pose_values = true, .stamps = true, .names = false};
constexpr Room kPoseTable{.edges = false, .observations = false, .pose_values = true, .stamps = true};

/// The row of a format; rows are in the order of LogFormat, in which formats are recognised.
const Format& row_of(LogFormat format) {
  static const std::array<Format, 9> rows{{
      {".g2o",
       begins<is_g2o_tag>,
       read_g2o_text,
       write_g2o<2>,
       write_g2o<3>,
       {.priors = true, .pose_values = true, .feature_values = true, .fixed = true, .one_numbering = true}},
      edges_row<kToroPlane, &kToroSpace>(".graph", begins_like_isam<is_toro_tag>, write_edges<3, kToroSpace>),
      edges_row<kGtsamText, nullptr>(".gtsam", begins_like_isam<is_gtsam_odometry>, nullptr),
      edges_row<kIsamPlane, &kIsamSpace>(".isam", begins<is_isam_tag>, write_edges<3, kIsamSpace>),
      edges_row<kOdomObs, nullptr>(".txt", begins<is_covariance_text_tag>, nullptr, read_text<read_covariance_text>),
      {".mat", is_mat_file, read_mat_log, write_mat_log, nullptr, {.weights = Weights::kCovariance}},
      {".tum", begins<is_tum_line>, read_text<read_tum_log>, write_values<2, write_tum>, write_values<3, write_tum>,
       kStampedTrajectory},
      {".kitti", begins<is_kitti_line>, read_text<read_kitti_log>, write_values<2, write_kitti>, write_values<3, write_kitti>,
       kTrajectory},
      {".csv", is_pose_csv, read_pose_csv, write_values<2, write_pose_csv>, write_values<3, write_pose_csv>, kPoseTable},
  }};
  return rows[static_cast<std::size_t>(format)];
}

struct Known {
  LogFormat format = {};
  std::size_t begin = 0;  ///< Start of the line by which the format is known.
};

/// What follows the first line of a text and the end of that line; `line` is its reader, which has read it.
std::string_view behind(const TextScanner& line, std::string_view text) {
  const std::size_t end = text.find('\n', text.size() - line.size());
  return end == text.npos ? std::string_view() : text.substr(end + 1);
}

/// The format that the options ask for, otherwise the one known by the first line that may not be left out, and the start of
/// that line; nullopt if no format is known.
std::optional<Known> known_format(std::string_view bytes, const ReadOptions& options) {
  if (options.from && row_of(*options.from).room.edges) return Known{*options.from};  // Its reader leaves lines out itself.
  for (std::string_view rest = bytes;;) {
    for (const auto& [format, name] : enum_names(LogFormat{})) {
      if (options.from.value_or(format) == format && row_of(format).is(rest)) return Known{format, bytes.size() - rest.size()};
    }
    TextScanner line("", rest);
    if (!options.skip_unknown || !line.next_line()) break;
    rest = behind(line, rest);
  }
  return options.from ? std::optional(Known{*options.from}) : std::nullopt;
}

/// Reads a table whose lines begin at `known.begin`; those before it are left out, and counted.
Expected<AnyLog> read_table(const Known& known, std::string_view bytes, const std::string& file, const ReadOptions& options) {
  std::string table(bytes);
  std::replace_if(
      table.begin(), table.begin() + static_cast<std::ptrdiff_t>(known.begin), [](char c) { return c != '\n'; }, ' ');
  return row_of(known.format).read(table, file, options).map([&](AnyLog any) {
    for (TextScanner before(file, bytes.substr(0, known.begin)); before.next_line();) {
      std::visit([&](auto& log) { ++log.skipped[lines_of(before.word())]; }, any);
    }
    return any;
  });
}

/// The number of poses and features that no edge mentions.
template <int Dim>
std::size_t unmentioned(const Log<Dim>& log) {
  Table<PoseIndex, bool> pose(log.poses.size());
  Table<FeatureIndex, bool> feature(log.features.size());
  for (const auto& edge : log.edges()) pose[edge.base] = pose[edge.target] = true;
  for (const auto& o : log.observations()) pose[o.base] = feature[o.target] = true;
  return static_cast<std::size_t>(std::count(pose.begin(), pose.end(), false) +
                                  std::count(feature.begin(), feature.end(), false));
}

template <int Dim>
void tell_rounding(const Room& room, std::vector<std::string>& lost) {
  if (room.weights == Weights::kSquareRoot) lost.emplace_back("weights are square roots of information matrices, rounded");
  if (room.weights == Weights::kCovariance) lost.emplace_back("weights are covariances, rounded");
  const bool has_angles = room.weights == Weights::kAngles || room.weights == Weights::kSquareRoot;
  if (Dim == 3 && has_angles) lost.emplace_back("rotations and their weights are those of roll, pitch and yaw, rounded");
}

}  // namespace

bool are_counted(const std::vector<PoseId>& poses) {
  for (std::size_t k = 0; k < poses.size(); ++k) {
    if (poses[k] != PoseId{0, k}) return false;
  }
  return true;
}

std::string_view file_extension(LogFormat format) {
  return row_of(format).extension;
}

bool needs_values(LogFormat format) {
  const Room room = row_of(format).room;
  return room.pose_values && !room.feature_values;
}

template <int Dim>
std::vector<std::string> losses(const Log<Dim>& log, LogFormat format) {
  const Room room = row_of(format).room;
  std::vector<std::string> lost;
  const auto tell = [&](std::size_t count, const std::string& what) {
    if (count > 0) lost.push_back(fmt::format("{} left out", what));
  };
  if (!room.edges) tell(log.edges().size(), plural(log.edges().size(), "pose-pose edge"));
  if (!room.observations) {
    tell(log.features.size(),
         plural(log.features.size(), "feature") + " with " + plural(log.observations().size(), "observation"));
  }
  const std::size_t priors = log.pose_priors().size() + log.feature_priors().size();
  if (!room.priors) tell(priors, plural(priors, "prior"));
  if (!room.fixed) tell(log.graph.fixed.size(), "which poses are fixed is");
  const bool has_values = !log.initial.poses.empty() || !log.initial.features.empty();
  const bool all_values = !log.initial.poses.empty() && log.initial.features.size() == log.features.size();
  if (!room.pose_values || (room.feature_values && !all_values))
    tell(has_values ? 1 : 0, "the values of poses and features are");
  tell(count_losses(log.graph), "losses of factors are");
  if (!room.stamps) tell(log.stamps_ns.size(), "time stamps are");
  const bool names_all = needs_values(format) || (room.feature_values && all_values);
  if (!names_all) tell(unmentioned(log), "poses and features that no edge mentions are");
  if (room.names && format != LogFormat::kCsv) {
    const auto numbering = number_for_g2o(log.poses, room.one_numbering ? log.features : FeatureIds());
    if (numbering) std::ranges::move(in_words(*numbering), std::back_inserter(lost));  // Otherwise the writer says why.
  }
  if (!room.names) {
    if (!are_counted(log.poses)) lost.emplace_back("poses are counted, not named");
    if (Dim == 2) lost.emplace_back("headings are rotations in space, rounded");
    if (Dim == 3 && format == LogFormat::kKitti) lost.emplace_back("rotations are matrices, rounded");
  }
  tell_rounding<Dim>(room, lost);
  return lost;
}

Expected<AnyLog> read_log(std::string_view bytes, const std::string& file, const ReadOptions& options) {
  if (const auto known = known_format(bytes, options)) {
    const Format& format = row_of(known->format);
    if (known->format != LogFormat::kG2o && options.turns_information()) return not_in_g2o(file);
    const bool is_alone = format.room.edges || known->begin == 0;  // Readers of edges leave lines out by their tag.
    auto any = is_alone ? format.read(bytes, file, options) : read_table(*known, bytes, file, options);
    if (any) std::visit([](auto& log) { count_others_together(log.skipped); }, *any);
    return any;
  }
  TextScanner text(file, bytes);
  if (!text.next_line()) return bad_input(fmt::format("{}: the file has nothing but blanks and comments", file));
  const auto other = known_format(bytes, {.skip_unknown = true});
  const std::string_view lines = other && row_of(other->format).room.edges ? "such lines" : "the lines before the table";
  return text.error(fmt::format("no log format has lines that begin with {}; {}--from names the format", in_quotes(text.word()),
                                other ? fmt::format("--skip-unknown leaves {} out, ", lines) : ""));
}

template <int Dim>
Expected<void> write_log(const Log<Dim>& log, LogFormat format, const fs::path& path) {
  const Format& row = row_of(format);
  const auto cannot = [&](const char* why) {
    return tl::unexpected(Error{ErrorKind::kUsage, fmt::format("{}: the format {} {}", log.source, to_string(format), why)});
  };
  if (needs_values(format) && log.initial.poses.empty()) return cannot("needs the values of all poses");
  const bool is_nothing = !row.room.pose_values && log.edges().empty() && log.observations().empty();
  if (is_nothing)
    return cannot("has only edges and observations, and the log has none; g2o keeps values, priors and fixed poses");
  if constexpr (Dim == 2) {
    return row.write_plane(log, path);
  } else {
    return row.write_space ? row.write_space(log, path) : cannot("is for the plane");
  }
}

template std::vector<std::string> losses(const Log<2>&, LogFormat);
template std::vector<std::string> losses(const Log<3>&, LogFormat);
template Expected<void> write_log(const Log<2>&, LogFormat, const fs::path&);
template Expected<void> write_log(const Log<3>&, LogFormat, const fs::path&);

}  // namespace mapjoin
