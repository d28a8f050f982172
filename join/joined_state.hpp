// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// In which coordinates the steps of a join are taken.

#include <cstdint>
#include <string>

namespace mapjoin {

enum class JoinedState : std::uint8_t {
  kAbsolute,  ///< Poses and features in the frame of the map (paper's (30)).
  kRelative,  ///< Each relative to the pose it hangs from (paper's (33)).
};

/// "absolute" or "relative".
std::string to_string(JoinedState state);

}  // namespace mapjoin
