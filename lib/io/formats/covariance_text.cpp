// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/formats/covariance_text.hpp>
#include <mapjoin/io/formats/edge_text.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <utility>

namespace mapjoin {
namespace {

constexpr std::string_view kStep = "STEP";
constexpr std::string_view kCircle = "LANDMARK_C";

/// A quality may stand before the covariance.
MeasuredPoint<2> read_circle(TextScanner& text, const TextContext&) {
  const Point<2> measured = text.vector<2>();
  Vector<3> P = text.vector<3>();
  if (!text.at_end_of_line()) P << P[1], P[2], text.number();
  return {measured, (Matrix<2>() << P[0], P[1], P[1], P[2]).finished()};
}

constexpr EdgeText<2> kOdomObs{
    .name = "the text form of Victoria Park's data",
    .comment = "ODOM i j x y phi, covariance row by row; OBS i feature x y, covariance",
    .edge_tag = "ODOM",
    .observation_tag = "OBS",
    .has_covariances = true,
    .may_be_unassociated = true,
    .read_point = read_circle,
};

constexpr EdgeText<2> kGtsamText{
    .name = "GTSAM's text files",
    .comment = "GTSAM: ODOMETRY i j x y phi, covariance row by row; LANDMARK i feature x y, covariance; one numbering",
    .edge_tag = "ODOMETRY",
    .observation_tag = "LANDMARK",
    .one_numbering = true,
    .has_covariances = true,
};

bool is_map_circles_tag(std::string_view tag) {
  return tag == kStep || tag == kCircle;
}

/// The lines of `map.circles`, which count steps and name no poses.
class MapCirclesReader {
 public:
  MapCirclesReader(TextScanner text, const ReadOptions& options)
      : text_(std::move(text)), check_(options.repair_information), builder_(text_.source()) {}

  Expected<AnyLog> read() && {
    while (text_.next_line()) {
      const std::string_view tag = text_.word();
      if (!is_map_circles_tag(tag)) return text_.error(fmt::format("unknown tag {}", in_quotes(tag)));
      if (tag == kStep) {
        read_step();
      } else {
        read_circle();
      }
      if (auto line = text_.finish_line(); !line) return tl::unexpected(line.error());
    }
    builder_.add_repairs(check_.repairs());
    return std::move(builder_).finish();
  }

 private:
  void read_step() {
    text_.word();  // The image.
    const Pose<2> motion = read_g2o_pose<2>(text_);
    const Matrix<2> P_translation = text_.symmetric<2>();
    const Vector<3> P_heading = text_.vector<3>();
    Matrix<3> P;
    P << P_translation, P_heading.head<2>(), P_heading.transpose();
    builder_.add_pose_edge({0, step_}, {0, step_ + 1}, motion, inverse_of(P, check_, text_));
    ++step_;
  }

  void read_circle() {
    const Point<2> measured = text_.vector<2>();
    text_.number();  // The quality.
    const Matrix<2> P = text_.symmetric<2>();
    if (const auto feature = read_feature_or_none(text_)) {
      builder_.add_observation({0, step_}, *feature, measured, inverse_of(P, check_, text_));
    } else {
      builder_.add_unassociated();
    }
  }

  TextScanner text_;
  InformationCheck check_;
  LogBuilder<2> builder_;
  std::uint64_t step_ = 0;  ///< The pose that the last step leads to.
};

}  // namespace

bool is_covariance_text_tag(std::string_view tag) {
  return kOdomObs.has_tag(tag) || is_map_circles_tag(tag);
}

Expected<AnyLog> read_covariance_text(TextScanner text, const ReadOptions& options) {
  TextScanner ahead = text;
  if (ahead.next_line() && is_map_circles_tag(ahead.word())) return MapCirclesReader(std::move(text), options).read();
  return read_edge_text(std::move(text), kOdomObs, nullptr, options);
}

Expected<void> write_odom_obs(const Log<2>& log, const std::filesystem::path& path) {
  return write_edge_text(log, kOdomObs, path);
}

bool is_gtsam_odometry_tag(std::string_view tag) {
  return tag == kGtsamText.edge_tag;
}

Expected<AnyLog> read_gtsam_text(TextScanner text, const ReadOptions& options) {
  return read_edge_text(std::move(text), kGtsamText, nullptr, options);
}

Expected<void> write_gtsam_text(const Log<2>& log, const std::filesystem::path& path) {
  return write_edge_text(log, kGtsamText, path);
}

}  // namespace mapjoin
