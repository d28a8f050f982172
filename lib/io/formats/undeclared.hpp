// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the lines of a text of edges name and no vertex declares, and what `FIX` lines name.

#include <cstdint>
#include <functional>
#include <mapjoin/io/formats/edge_text.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin {

/// Names in a log's counts of what was left out.
inline constexpr std::string_view kEdgesToUndeclared = "edges to undeclared vertices";
inline constexpr std::string_view kFixedUndeclared = "fixed vertices that are undeclared";

/// The ids that vertices declare.
struct Declared {
  std::function<bool(std::uint64_t)> has_pose;
  std::function<bool(std::uint64_t)> has_feature;
};

/// A pose or feature that a line names and no vertex declares, with the place of the line's tag.
struct UndeclaredName {
  Place place;
  std::string name;
};

/// The first such pose or feature in a text at its start; nullopt if there is none. Edges between poses are passed over unless
/// `with_edges`.
template <int Dim>
std::optional<UndeclaredName> first_undeclared(TextScanner text, const EdgeText<Dim>& format, const Declared& declared,
                                               bool with_edges);

/// An id that a `FIX` line names, and its place.
struct FixedName {
  std::uint64_t key;
  Place place;
};

/// Those of `keys` that no edge to another pose, observation or prior in a text at its start names as a pose.
template <int Dim>
std::set<std::uint64_t> not_named_as_poses(TextScanner text, const EdgeText<Dim>& format, std::set<std::uint64_t> keys);

/// The ids that `FIX` lines of a text at its start name, in their order.
std::vector<FixedName> fixed_names(TextScanner text);

}  // namespace mapjoin
