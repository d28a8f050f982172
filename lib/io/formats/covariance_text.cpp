// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/formats/covariance_text.hpp>
#include <mapjoin/io/formats/covariance_weights.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

constexpr std::string_view kOdometry = "ODOM";
constexpr std::string_view kObservation = "OBS";
constexpr std::string_view kStep = "STEP";
constexpr std::string_view kCircle = "LANDMARK_C";
constexpr std::int64_t kUnassociated = -1;

bool is_odom_obs_tag(std::string_view tag) {
  return tag == kOdometry || tag == kObservation;
}
bool is_map_circles_tag(std::string_view tag) {
  return tag == kStep || tag == kCircle;
}

/// An id, or nothing for -1.
std::optional<FeatureId> read_feature(TextScanner& text) {
  const std::int64_t key = text.integer();
  if (key == kUnassociated) return std::nullopt;
  if (key < 0) text.reject(fmt::format("a feature has the id {}", key));
  return FeatureId{static_cast<std::uint64_t>(key)};
}

/// Reads line by line what both formats say, each in its way.
class CovarianceTextReader {
 public:
  CovarianceTextReader(TextScanner text, const ReadOptions& options)
      : text_(std::move(text)), check_(options.repair_information), builder_(text_.source()) {}

  Expected<AnyLog> read() {
    TextScanner ahead = text_;
    const bool counts_steps = ahead.next_line() && is_map_circles_tag(ahead.word());
    while (text_.next_line()) {
      const std::string_view tag = text_.word();
      const auto line = counts_steps ? read_map_circles_line(tag) : read_odom_obs_line(tag);
      if (!line) return tl::unexpected(line.error());
    }
    auto log = std::move(builder_).finish();
    if (!log) return tl::unexpected(log.error());
    log->unassociated = unassociated_;
    log->conventions.repairs = check_.repairs();
    return AnyLog(*std::move(log));
  }

 private:
  Expected<void> read_odom_obs_line(std::string_view tag) {
    if (tag == kOdometry) return read_odometry();
    if (tag == kObservation) return read_observation();
    return unknown(tag);
  }

  Expected<void> read_map_circles_line(std::string_view tag) {
    if (tag == kStep) return read_step();
    if (tag == kCircle) return read_circle();
    return unknown(tag);
  }

  Expected<void> unknown(std::string_view tag) { return text_.error(fmt::format("unknown tag {}", in_quotes(tag))); }

  Expected<void> add_motion(PoseId base, PoseId target, const Pose<2>& measured, const Matrix<3>& W) {
    if (base == target) text_.reject(fmt::format("an edge leads from {} to itself", to_string(base)));
    builder_.add_pose_edge(base, target, measured, W);
    return text_.finish_line();
  }

  Expected<void> add_observation(PoseId pose, std::optional<FeatureId> feature, const Point<2>& measured, const Matrix<2>& P) {
    if (feature) {
      builder_.add_observation(pose, *feature, measured, inverse_of(P, check_, text_));
    } else {
      ++unassociated_;
    }
    return text_.finish_line();
  }

  Expected<void> read_odometry() {
    const PoseId base{0, text_.key()};
    const PoseId target{0, text_.key()};
    const MeasuredPose<2> edge = read_covariance_edge(text_, check_);
    return add_motion(base, target, edge.measured, edge.information);
  }

  Expected<void> read_observation() {
    const PoseId pose{0, text_.key()};
    const auto feature = read_feature(text_);
    const Point<2> measured = text_.vector<2>();
    const Vector<3> three = text_.vector<3>();
    if (text_.at_end_of_line()) return add_observation(pose, feature, measured, symmetric(three[0], three[1], three[2]));
    return add_observation(pose, feature, measured, symmetric(three[1], three[2], text_.number()));
  }

  Expected<void> read_step() {
    text_.word();  // The image.
    const Pose<2> motion = read_g2o_pose<2>(text_);
    const Matrix<2> P_translation = text_.symmetric<2>();
    const Vector<3> P_heading = text_.vector<3>();
    Matrix<3> P;
    P << P_translation, P_heading.head<2>(), P_heading.transpose();
    const PoseId before{0, step_++};
    return add_motion(before, {0, step_}, motion, inverse_of(P, check_, text_));
  }

  Expected<void> read_circle() {
    const Point<2> measured = text_.vector<2>();
    text_.number();  // The quality.
    const Matrix<2> P = text_.symmetric<2>();
    const auto feature = read_feature(text_);
    return add_observation({0, step_}, feature, measured, P);
  }

  static Matrix<2> symmetric(double xx, double xy, double yy) { return (Matrix<2>() << xx, xy, xy, yy).finished(); }

  TextScanner text_;
  InformationCheck check_;
  LogBuilder<2> builder_;
  std::uint64_t step_ = 0;  ///< The pose that the last step leads to.
  std::int64_t unassociated_ = 0;
};

}  // namespace

bool is_covariance_text_tag(std::string_view tag) {
  return is_odom_obs_tag(tag) || is_map_circles_tag(tag);
}

Expected<AnyLog> read_covariance_text(TextScanner text, const ReadOptions& options) {
  return CovarianceTextReader(std::move(text), options).read();
}

Expected<void> write_odom_obs(const Log<2>& log, const std::filesystem::path& path) {
  constexpr EdgeText<2> kFormat{
      .name = "the text form of Victoria Park's data",
      .comment = "ODOM i j x y phi, covariance row by row; OBS i feature x y, covariance",
      .edge_tag = kOdometry,
      .observation_tag = kObservation,
      .put_edge = put_covariance_edge,
      .put_point = put_covariance_point,
  };
  return write_edge_text(log, kFormat, path);
}

}  // namespace mapjoin
