// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Text within SVG and HTML.

#include <string>
#include <string_view>

namespace mapjoin::apps {

/// With the characters that markup is made of, &, <, > and ", as entities.
std::string escaped(std::string_view text);

/// The begin of an SVG on white, of so many pixels; `</svg>` ends it.
std::string svg_head(double width, double height, double font_size);

}  // namespace mapjoin::apps
