// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The four least-squares problems that the paper compares: full SLAM and joining, each in absolute or relative coordinates.

#include <array>
#include <mapjoin/join/joined_state.hpp>
#include <string>

namespace mapjoin {

struct Formulation {
  bool is_joining = false;  ///< True for joining local maps (31), false for full SLAM (8), (9), the join of one-step maps.
  JoinedState state = JoinedState::kAbsolute;
  bool operator==(const Formulation&) const = default;
};

/// The four formulations in the paper's order: (9), (24), (32), (35).
inline constexpr std::array<Formulation, 4> kFormulations = {{
    {false, JoinedState::kAbsolute},
    {false, JoinedState::kRelative},
    {true, JoinedState::kAbsolute},
    {true, JoinedState::kRelative},
}};

/// The problem in words: "full SLAM" or "joining".
inline std::string problem_in_words(const Formulation& formulation) {
  return formulation.is_joining ? "joining" : "full SLAM";
}

/// The formulation in words: "full SLAM, absolute" and so on.
inline std::string to_string(const Formulation& formulation) {
  return problem_in_words(formulation) + ", " + to_string(formulation.state);
}

}  // namespace mapjoin
