// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The user's names of poses and features, and the dense indices that stand for them inside.

#include <compare>
#include <cstdint>
#include <string>

namespace mapjoin {

/// A dense index of a pose or of a feature; poses and features count from 0, apart.
using Index = std::int32_t;

/// As the base of an observation: the World, the frame that fixed poses, priors and GPS positions are given in.
inline constexpr Index kWorld = -1;

/// A pose as its log names it: keys may repeat between sessions (robots or runs), never within one.
struct PoseId {
  std::uint32_t session = 0;
  std::uint64_t key = 0;
  auto operator<=>(const PoseId&) const = default;
};

/// A feature as its log names it, in a space of its own: pose 7 and feature 7 are different things.
struct FeatureId {
  std::uint64_t key = 0;
  auto operator<=>(const FeatureId&) const = default;
};

/// "pose 17", or "pose 17 of session 2" where the session is not 0.
std::string to_string(const PoseId& id);
/// "feature 17".
std::string to_string(const FeatureId& id);

}  // namespace mapjoin
