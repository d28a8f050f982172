// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <mapjoin/model/ids.hpp>

namespace mapjoin {

std::optional<std::uint64_t> parse_key(std::string_view text) {
  const std::uint64_t symbol = text.empty() ? 0 : std::uint64_t{static_cast<unsigned char>(text.front())} << 56;
  const bool has_letter = symbol_letter(symbol) != '\0';
  const std::string_view digits = text.substr(has_letter ? 1 : 0);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  if (has_letter && number >> 56 != 0) return std::nullopt;
  return has_letter ? symbol | number : number;
}

}  // namespace mapjoin
