// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/picture/markup.hpp>
#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>

namespace mapjoin::apps {

namespace {

/// The number of bytes of the first character of a text in UTF-8; 0 if it is none that markup may hold.
std::size_t first_character(std::string_view text) {
  const auto byte = [text](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0U; };
  const unsigned lead = byte(0);
  if (lead < 0x80) return lead == '\t' || lead == '\n' || (lead >= 0x20 && lead != 0x7F) ? 1 : 0;
  // The second byte tells forms that are too long, surrogates and what is beyond U+10FFFF.
  const unsigned least = lead == 0xE0 ? 0xA0 : lead == 0xF0 ? 0x90 : 0x80;
  const unsigned most = lead == 0xED ? 0x9F : lead == 0xF4 ? 0x8F : 0xBF;
  if (lead < 0xC2 || lead > 0xF4 || byte(1) < least || byte(1) > most) return 0;
  const std::size_t length = lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  for (std::size_t k = 2; k < length; ++k) {
    if ((byte(k) & 0xC0U) != 0x80U) return 0;
  }
  const bool is_no_character = text.starts_with("\uFFFE") || text.starts_with("\uFFFF");
  return is_no_character ? 0 : length;
}

/// A character as markup has it; "" stands for one that it may not hold.
std::string_view in_markup(std::string_view character) {
  if (character.empty()) return "\uFFFD";
  if (character == "&") return "&amp;";
  if (character == "<") return "&lt;";
  if (character == ">") return "&gt;";
  if (character == "\"") return "&quot;";
  return character;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string markup;
  while (!text.empty()) {
    const std::size_t length = first_character(text);
    markup += in_markup(text.substr(0, length));
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return markup;
}

std::string html_page(const std::string& title, std::string_view style, std::string_view body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\"/>\n<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n{}"
      "</body>\n</html>\n",
      escaped(title), style, body);
}

std::string base64(std::string_view bytes) {
  namespace iterators = boost::archive::iterators;
  using Digits = iterators::base64_from_binary<iterators::transform_width<std::string::const_iterator, 6, 8>>;
  const std::size_t missing = (3 - bytes.size() % 3) % 3;  // to whole groups of three
  const std::string whole = std::string(bytes) + std::string(missing, '\0');
  std::string text(Digits(whole.begin()), Digits(whole.end()));
  return text.replace(text.size() - missing, missing, missing, '=');
}

}  // namespace mapjoin::apps
