// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/picture/markup.hpp>
#include <boost/algorithm/string/replace.hpp>
#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>

namespace mapjoin::apps {

std::string escaped(std::string text) {
  boost::replace_all(text, "&", "&amp;");
  boost::replace_all(text, "<", "&lt;");
  boost::replace_all(text, ">", "&gt;");
  boost::replace_all(text, "\"", "&quot;");
  return text;
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
