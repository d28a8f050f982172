// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The user's names of poses and features, and the dense indices that stand for them inside.

#include <algorithm>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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

/// The index of `id` among ascending names; nothing where it is not there. Constant time where keys are consecutive, else
/// logarithmic.
template <typename Id>
std::optional<Index> find_ascending(const std::vector<Id>& names, const Id& id) {
  const std::uint64_t guess = names.empty() ? 0 : id.key - names.front().key;
  if (guess < names.size() && names[guess] == id) return static_cast<Index>(guess);
  const auto found = std::lower_bound(names.begin(), names.end(), id);
  if (found == names.end() || *found != id) return std::nullopt;
  return static_cast<Index>(found - names.begin());
}

/// The same among the names of a Log, MapSet or GlobalMap, linear where they are not ascending.
template <typename Id>
std::optional<Index> find_index(const std::vector<Id>& names, const Id& id) {
  if (const auto index = find_ascending(names, id)) return index;
  const auto found = std::is_sorted(names.begin(), names.end()) ? names.end() : std::find(names.begin(), names.end(), id);
  if (found == names.end()) return std::nullopt;
  return static_cast<Index>(found - names.begin());
}

/// "pose 17", or "pose 17 of session 2" where the session is not 0.
inline std::string to_string(const PoseId& id) {
  return "pose " + std::to_string(id.key) + (id.session == 0 ? "" : " of session " + std::to_string(id.session));
}
/// "feature 17".
inline std::string to_string(const FeatureId& id) {
  return "feature " + std::to_string(id.key);
}

}  // namespace mapjoin
