// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What is drawn together: maps of one dimension, in one frame, with the truth of the first one.

#include <apps/picture/plotted_map.hpp>
#include <mapjoin/join/consistency.hpp>
#include <optional>
#include <variant>
#include <vector>

namespace mapjoin::apps {

template <int Dim>
struct Scene {
  std::vector<PlottedMap<Dim>> maps;  ///< At least one.
  std::optional<Truth<Dim>> truth;    ///< Over the poses and features of the first map.
};

using AnyScene = std::variant<Scene<2>, Scene<3>>;

}  // namespace mapjoin::apps
