// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The tags of g2o files by dimension, shared by reader and writer.

#include <string_view>

namespace mapjoin {

template <int Dim>
struct G2oTags;

template <>
struct G2oTags<2> {
  static constexpr std::string_view kPose = "VERTEX_SE2";
  static constexpr std::string_view kFeature = "VERTEX_XY";
  static constexpr std::string_view kPoseEdge = "EDGE_SE2";
  static constexpr std::string_view kObservation = "EDGE_SE2_XY";
};

template <>
struct G2oTags<3> {
  static constexpr std::string_view kPose = "VERTEX_SE3:QUAT";
  static constexpr std::string_view kFeature = "VERTEX_TRACKXYZ";
  static constexpr std::string_view kPoseEdge = "EDGE_SE3:QUAT";
  static constexpr std::string_view kObservation = "EDGE_SE3_TRACKXYZ";
};

template <int Dim>
constexpr bool is_g2o_tag_of(std::string_view tag) {
  using Tags = G2oTags<Dim>;
  return tag == Tags::kPose || tag == Tags::kFeature || tag == Tags::kPoseEdge || tag == Tags::kObservation;
}

inline constexpr std::string_view kG2oFix = "FIX";
inline constexpr std::string_view kG2oOffset = "PARAMS_SE3OFFSET";

/// PARAMS_SE3OFFSET and its like, which say nothing until an observation names them.
constexpr bool is_g2o_parameter(std::string_view tag) {
  return tag.substr(0, 7) == "PARAMS_";
}

}  // namespace mapjoin
