// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The user's names of poses and features, and the dense indices that replace them internally.

#include <algorithm>
#include <charconv>
#include <compare>
#include <cstdint>
#include <mapjoin/model/index.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

namespace mapjoin {

/// Dense indices of poses and of features, each from 0.
using PoseIndex = StrongIndex<struct PoseTag>;
using FeatureIndex = StrongIndex<struct FeatureTag>;
using PoseOrFeature = std::variant<PoseIndex, FeatureIndex>;

/// The World as the base of an observation: the frame of fixed poses, priors and GPS positions.
inline constexpr PoseIndex kWorld = -1;

/// A pose as its log names it: keys may repeat between sessions (robots or runs), never within one.
struct PoseId {
  std::uint32_t session = 0;
  std::uint64_t key = 0;
  auto operator<=>(const PoseId&) const = default;
};

/// A feature as its log names it, in a namespace of its own: pose 7 and feature 7 are different things.
struct FeatureId {
  std::uint64_t key = 0;
  auto operator<=>(const FeatureId&) const = default;
};

/// The names of poses and of features, by their indices.
using PoseIds = Table<PoseIndex, PoseId>;
using FeatureIds = Table<FeatureIndex, FeatureId>;

/// The position of `id` among ascending names; nullopt if absent. Constant time if keys are consecutive, otherwise logarithmic.
template <typename Id>
std::optional<std::size_t> find_ascending(const std::vector<Id>& names, const Id& id) {
  const std::uint64_t guess = names.empty() ? 0 : id.key - names.front().key;
  if (guess < names.size() && names[guess] == id) return guess;
  const auto found = std::lower_bound(names.begin(), names.end(), id);
  if (found == names.end() || *found != id) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

/// The indices of ids among the names of a Log, SubmapSet or GlobalMap, in any order. O(n log n) once, then O(log n) each.
template <typename Index, typename Id>
class IndexOf {
 public:
  explicit IndexOf(const Table<Index, Id>& names) {
    for (const Index index : indices(names)) indices_.emplace_back(names[index], index);
    std::ranges::sort(indices_);
  }
  /// The index of `id`; nullopt if no name equals it.
  std::optional<Index> operator()(const Id& id) const {
    const auto found = std::ranges::lower_bound(indices_, id, {}, &std::pair<Id, Index>::first);
    if (found == indices_.end() || found->first != id) return std::nullopt;
    return found->second;
  }

 private:
  std::vector<std::pair<Id, Index>> indices_;
};

/// The letter of a key that is a GTSAM symbol: a letter in the top byte, for a robot or a kind, above an index; otherwise 0.
constexpr char symbol_letter(std::uint64_t key) {
  const auto letter = static_cast<char>(key >> 56);
  return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ? letter : '\0';
}
/// A key as text: "17", or "a17" if it is a GTSAM symbol.
inline std::string key_text(std::uint64_t key) {
  const char letter = symbol_letter(key);
  return letter == '\0' ? std::to_string(key) : letter + std::to_string(key & ((std::uint64_t{1} << 56) - 1));
}

/// The key whose key_text() this is; nullopt for any other text.
inline std::optional<std::uint64_t> parse_key(std::string_view text) {
  const std::uint64_t symbol = text.empty() ? 0 : std::uint64_t{static_cast<unsigned char>(text.front())} << 56;
  const bool has_letter = symbol_letter(symbol) != '\0';
  const std::string_view digits = text.substr(has_letter ? 1 : 0);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  if (has_letter && number >> 56 != 0) return std::nullopt;
  return has_letter ? symbol | number : number;
}

/// The name of a pose, "pose 17", or "pose 17 of session 2" if the session is not 0.
inline std::string to_string(const PoseId& id) {
  return "pose " + key_text(id.key) + (id.session == 0 ? "" : " of session " + std::to_string(id.session));
}
/// The name of a feature, "feature 17".
inline std::string to_string(const FeatureId& id) {
  return "feature " + key_text(id.key);
}

}  // namespace mapjoin
