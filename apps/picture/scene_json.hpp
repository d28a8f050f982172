// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a page shows, as the data that it brings along (read by viewer/scene.js).

#include <apps/picture/scene.hpp>
#include <string>

namespace mapjoin::apps {

/// JSON without a `<`, so that it can stand in a script element. Numbers are base64 of little-endian arrays; places are 32-bit
/// floats about the middle of the first map, which is given in full.
template <int Dim>
std::string scene_json(const Scene<Dim>& scene, const std::string& title);

}  // namespace mapjoin::apps
