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

/// The indices of ids among the names of a Log, SubmapSet or GlobalMap, in whatever order these are. O(n log n) once, then
/// O(log n) each.
template <typename Id>
class IndexOf {
 public:
  explicit IndexOf(const std::vector<Id>& names) {
    for (const Id& name : names) indices_.emplace_back(name, static_cast<Index>(indices_.size()));
    std::ranges::sort(indices_);
  }
  /// Nothing where no name is `id`.
  std::optional<Index> operator()(const Id& id) const {
    const auto found = std::ranges::lower_bound(indices_, id, {}, &std::pair<Id, Index>::first);
    if (found == indices_.end() || found->first != id) return std::nullopt;
    return found->second;
  }

 private:
  std::vector<std::pair<Id, Index>> indices_;
};

/// "pose 17", or "pose 17 of session 2" where the session is not 0.
inline std::string to_string(const PoseId& id) {
  return "pose " + std::to_string(id.key) + (id.session == 0 ? "" : " of session " + std::to_string(id.session));
}
/// "feature 17".
inline std::string to_string(const FeatureId& id) {
  return "feature " + std::to_string(id.key);
}

}  // namespace mapjoin
