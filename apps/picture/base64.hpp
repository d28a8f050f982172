// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Bytes as text: base64 (RFC 4648), for what a page brings along.

#include <string>
#include <string_view>
#include <vector>

namespace mapjoin::apps {

std::string base64(std::string_view bytes);

/// Of numbers as they lie in memory: little-endian on every machine we build for.
template <typename T>
std::string base64(const std::vector<T>& numbers) {
  return base64(std::string_view(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T)));
}

}  // namespace mapjoin::apps
