// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/formats/covariance_weights.hpp>
#include <mapjoin/io/formats/gtsam_text.hpp>

namespace mapjoin {
namespace {

constexpr EdgeText<2> kGtsamText{
    .name = "GTSAM's text files",
    .comment = "GTSAM: ODOMETRY i j x y phi, covariance row by row; LANDMARK i feature x y, covariance; one numbering",
    .edge_tag = "ODOMETRY",
    .observation_tag = "LANDMARK",
    .one_numbering = true,
    .read_edge = read_covariance_edge,
    .read_point = read_covariance_point,
    .put_edge = put_covariance_edge,
    .put_point = put_covariance_point,
};

}  // namespace

bool is_gtsam_odometry_tag(std::string_view tag) {
  return tag == kGtsamText.edge_tag;
}

Expected<AnyLog> read_gtsam_text(TextScanner text, const ReadOptions& options) {
  return read_edge_text(std::move(text), kGtsamText, options);
}

Expected<void> write_gtsam_text(const Log<2>& log, const std::filesystem::path& path) {
  return write_edge_text(log, kGtsamText, path);
}

}  // namespace mapjoin
