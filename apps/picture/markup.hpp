// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Text, colours and data within SVG and HTML.

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin::apps {

/// The text with the characters that markup is made of, &, <, > and ", as entities, and with U+FFFD for each byte that is not
/// of a character in UTF-8, as file names may have, and for each control character of ASCII but tab and newline.
std::string escaped(std::string_view text);

/// A whole HTML page; well-formed XML if its body is.
std::string html_page(const std::string& title, std::string_view style, std::string_view body);

/// The colours of Okabe and Ito, for all kinds of colour vision; without their yellow, which is too light for a line.
inline constexpr std::array kDistinctColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"};

std::string base64(std::string_view bytes);

/// Base64 of numbers as they lie in memory: little-endian on every machine we build for.
template <typename T>
std::string base64(const std::vector<T>& numbers) {
  return base64(std::string_view(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T)));
}

}  // namespace mapjoin::apps
