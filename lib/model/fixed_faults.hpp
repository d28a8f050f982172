// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What is wrong with a pose that a log fixes, in words.

#include <fmt/format.h>

#include <mapjoin/model/ids.hpp>
#include <string>

namespace mapjoin {

/// Nothing but its fixing names the pose.
inline std::string fixed_without_pose(const PoseId& id) {
  return to_string(id) + " is fixed, but the log has no such pose (a feature is not fixed, but held by a prior)";
}

/// Neither the pose nor the other one, which is fixed, too, has a value.
inline std::string fixed_nowhere(const PoseId& id, const PoseId& other) {
  return fmt::format(
      "{} is fixed beside {}, but nothing says where: give it a value (in a g2o file, its vertex) or fix one of "
      "the two only",
      to_string(id), to_string(other));
}

}  // namespace mapjoin
