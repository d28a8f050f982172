// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Text, colours and data within SVG and HTML.

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin::apps {

/// With the characters that markup is made of, &, <, > and ", as entities.
std::string escaped(std::string text);

/// A whole page; well-formed XML where its body is.
std::string html_page(const std::string& title, std::string_view style, std::string_view body);

/// Okabe and Ito's, for all kinds of colour vision; without their yellow, which is too light for a line.
inline constexpr std::array kDistinctColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"};

std::string base64(std::string_view bytes);

/// Of numbers as they lie in memory: little-endian on every machine we build for.
template <typename T>
std::string base64(const std::vector<T>& numbers) {
  return base64(std::string_view(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T)));
}

}  // namespace mapjoin::apps
