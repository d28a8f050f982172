// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <mapjoin/io/g2o_fields.hpp>
#include <mapjoin/io/g2o_tags.hpp>

namespace mapjoin {

template <>
Pose<2> read_g2o_pose<2>(TextScanner& text) {
  const Vector<3> v = text.vector<3>();
  return {v.head<2>(), Rotation<2>(v[2])};
}

// A quaternion of unit length to round-off is kept as it is, so that what was written reads back as the same bits.
template <>
Pose<3> read_g2o_pose<3>(TextScanner& text) {
  constexpr double kRoundOff = 1e-14;
  const Vector<3> translation = text.vector<3>();
  Eigen::Quaterniond q(text.vector<4>());
  const double squared = q.squaredNorm();
  if (squared < 0.25 || squared > 4.0) text.reject("the four numbers up to here are not a unit quaternion");
  if (std::abs(squared - 1.0) > kRoundOff) q.normalize();
  return {translation, Rotation<3>(q)};
}

Expected<G2oOffsets> read_g2o_offsets(TextScanner text) {
  G2oOffsets offsets;
  while (text.next_line()) {
    if (text.word() != kG2oOffset) continue;
    const std::uint64_t key = text.key();
    const Place place = text.place();
    const Pose<3> robot_sensor = read_g2o_pose<3>(text);
    if (auto line = text.finish_line(); !line) return tl::unexpected(line.error());
    if (!offsets.emplace(key, robot_sensor).second) {
      return text.error(place, fmt::format("sensor offset {} is given a second time", key));
    }
  }
  return offsets;
}

}  // namespace mapjoin
