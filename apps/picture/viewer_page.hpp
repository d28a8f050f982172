// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One self-contained page to look around in a scene: three.js and the scripts of viewer/, and the scene as data.

#include <apps/picture/plotted_map.hpp>
#include <string>

namespace mapjoin::apps {

template <int Dim>
std::string viewer_page(const Scene<Dim>& scene, const std::string& title);

}  // namespace mapjoin::apps
