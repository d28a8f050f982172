// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One self-contained page to look around in a scene: three.js and the scripts of viewer/, and the scene as data.

#include <apps/picture/plotted_map.hpp>
#include <string>

namespace mapjoin::apps {

template <int Dim>
std::string viewer_page(const Scene<Dim>& scene, const std::string& title);

/// JSON without a `<`, so that it can stand in a script element. Numbers are base64 of little-endian arrays; places are 32-bit
/// floats about the middle of the first map, which is given in full.
template <int Dim>
std::string scene_json(const Scene<Dim>& scene, const std::string& title);

}  // namespace mapjoin::apps
