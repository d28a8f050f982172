// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/covariance_text.hpp>
#include <mapjoin/io/file_bytes.hpp>
#include <mapjoin/io/g2o.hpp>
#include <mapjoin/io/gtsam_text.hpp>
#include <mapjoin/io/isam.hpp>
#include <mapjoin/io/mat_log.hpp>
#include <mapjoin/io/mat_structure.hpp>
#include <mapjoin/io/mrclam.hpp>
#include <mapjoin/io/open_log.hpp>
#include <mapjoin/io/text_scanner.hpp>
#include <mapjoin/io/toro.hpp>
#include <mapjoin/io/trajectory.hpp>
#include <string_view>
#include <utility>

namespace mapjoin {
namespace {

/// A text format, known by the words that its lines begin with.
struct TextFormat {
  bool (*is_tag)(std::string_view tag);
  Expected<AnyLog> (*read)(TextScanner text, const ReadOptions& options);
};

/// iSAM's log, unless a later line has a tag that TORO's or GTSAM's files have beside its own.
Expected<AnyLog> read_isam_like(TextScanner text, const ReadOptions& options) {
  for (TextScanner ahead = text; ahead.next_line();) {
    const std::string_view tag = ahead.word();
    if (is_toro_vertex_tag(tag)) return read_toro(std::move(text), options);
    if (is_gtsam_odometry_tag(tag)) return read_gtsam_text(std::move(text), options);
  }
  return read_isam(std::move(text), options);
}

constexpr TextFormat kTextFormats[] = {
    {is_g2o_tag, read_g2o},        {is_toro_vertex_tag, read_toro},  {is_gtsam_odometry_tag, read_gtsam_text},
    {is_isam_tag, read_isam_like}, {is_odom_obs_tag, read_odom_obs}, {is_map_circles_tag, read_map_circles},
};

}  // namespace

Expected<AnyLog> open_log(const std::filesystem::path& path, const ReadOptions& options) {
  if (is_mrclam_folder(path)) return read_mrclam(path);
  const auto bytes = FileBytes::read(path);
  if (!bytes) return tl::unexpected(bytes.error());
  if (is_mat_file(bytes->view())) return read_mat_log(bytes->view(), path.string(), options);

  const TextScanner text(path.string(), bytes->view());
  TextScanner ahead = text;
  if (!ahead.next_line()) return bad_input(fmt::format("{}: the file has nothing but blanks and comments", path.string()));
  const std::string_view tag = ahead.word();
  for (const TextFormat& format : kTextFormats) {
    if (format.is_tag(tag)) return format.read(text, options);
  }
  if (is_tum_line(text)) return read_tum_log(text, options);
  if (is_kitti_line(text)) return read_kitti_log(text, options);
  return ahead.error(fmt::format("no log format has lines that begin with {}", in_quotes(tag)));
}

}  // namespace mapjoin
