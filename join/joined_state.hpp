// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// In which coordinates the steps of a join are taken.

#include <cstdint>
#include <mapjoin/model/enum_names.hpp>

namespace mapjoin {

enum class JoinedState : std::uint8_t {
  kAbsolute,  ///< Poses and features in the frame of the map (paper's (30)).
  kRelative,  ///< Each relative to its parent in the spanning tree (paper's (33)).
};

constexpr auto enum_names(JoinedState) {
  return std::to_array<EnumName<JoinedState>>({{JoinedState::kAbsolute, "absolute"}, {JoinedState::kRelative, "relative"}});
}

}  // namespace mapjoin
