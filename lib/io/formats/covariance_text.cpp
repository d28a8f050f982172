// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/formats/covariance_text.hpp>
#include <mapjoin/io/formats/skipped_lines.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <utility>

namespace mapjoin {
namespace {

constexpr std::string_view kStep = "STEP";
constexpr std::string_view kCircle = "LANDMARK_C";

/// Reads an observation; a quality may stand before its covariance.
MeasuredPoint<2> read_circle(TextScanner& text, const TextContext& context) {
  const Point<2> measured = text.vector<2>();
  if (is_unweighed(text, context)) return {measured, Matrix<2>::Identity()};
  Vector<3> P = text.vector<3>();
  if (!text.at_end_of_line()) P << P[1], P[2], text.number();
  return {measured, (Matrix<2>() << P[0], P[1], P[1], P[2]).finished()};
}

}  // namespace

const EdgeText<2> kOdomObs{
    .name = "the text form of Victoria Park's data",
    .comment = "ODOM i j x y phi, covariance row by row; OBS i feature x y, covariance",
    .edge_tag = "ODOM",
    .observation_tag = "OBS",
    .weights = Weights::kCovariance,
    .may_be_unassociated = true,
    .read_point = read_circle,
};

const EdgeText<2> kGtsamText{
    .name = "GTSAM's text files",
    .comment = "GTSAM: ODOMETRY i j x y phi, covariance row by row; LANDMARK i feature x y, covariance; one numbering",
    .edge_tag = "ODOMETRY",
    .observation_tag = "LANDMARK",
    .one_numbering = true,
    .weights = Weights::kCovariance,
};

namespace {

bool is_map_circles_tag(std::string_view tag) {
  return tag == kStep || tag == kCircle;
}

/// The log in lines of `map.circles`, which count steps and name no poses.
Expected<AnyLog> read_map_circles(TextScanner text, const ReadOptions& options) {
  InformationCheck check(options.repair_information);
  LogBuilder<2> builder(text.source());
  std::uint64_t step = 0;  // The pose that the last step leads to.
  const auto read_step = [&] {
    text.word();  // The image.
    const Pose<2> motion = read_g2o_pose<2>(text);
    const Matrix<2> P_translation = text.symmetric<2>();
    const Vector<3> P_heading = text.vector<3>();
    Matrix<3> P;
    P << P_translation, P_heading.head<2>(), P_heading.transpose();
    builder.add_pose_edge({0, step}, {0, step + 1}, motion, inverse_of(P, check, text));
    ++step;
  };
  const auto read_landmark = [&] {
    const Point<2> measured = text.vector<2>();
    text.number();  // The quality.
    const Matrix<2> P = text.symmetric<2>();
    const auto feature = read_feature_or_none(text);
    if (!feature) return builder.add_unassociated();
    builder.add_observation({0, step}, *feature, measured, inverse_of(P, check, text));
  };
  const auto read_line = [&] {
    const std::string_view tag = text.word();
    if (tag == kStep) return read_step();
    if (tag == kCircle) return read_landmark();
    if (!options.skip_unknown) return text.reject(fmt::format("unknown tag {}", in_quotes(tag)));
    builder.add_skipped(lines_of(tag));
    while (!text.at_end_of_line()) text.word();
  };
  return text.each_line(read_line).and_then([&]() -> Expected<AnyLog> {
    builder.add_repairs(check.repairs());
    return std::move(builder).finish();
  });
}

}  // namespace

bool is_covariance_text_tag(std::string_view tag) {
  return kOdomObs.has_tag(tag) || is_map_circles_tag(tag);
}

Expected<AnyLog> read_covariance_text(TextScanner text, const ReadOptions& options) {
  for (TextScanner ahead = text; ahead.next_line();) {
    const std::string_view tag = ahead.word();
    if (is_map_circles_tag(tag)) return read_map_circles(std::move(text), options);
    if (kOdomObs.has_tag(tag)) break;
  }
  return read_edge_text(std::move(text), kOdomObs, nullptr, options);
}

}  // namespace mapjoin
