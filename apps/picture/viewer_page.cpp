// SPDX-License-Identifier: BSD-3-Clause
#include <apps/picture/markup.hpp>
#include <apps/picture/viewer_page.hpp>
#include <string_view>

namespace mapjoin::apps {

// By cmake/embed.cmake, from viewer/ and from Debian's libjs-three.
namespace embedded {
extern const std::string_view viewer_style;
extern const std::string_view viewer_body;
extern const std::string_view viewer_scripts;
}  // namespace embedded

namespace {

constexpr std::string_view kNotice = R"(<!--
This page was made by mapjoin (BSD-3-Clause). It holds three.js r111 (https://threejs.org), under the MIT License:

Copyright (c) 2010-2019 three.js authors

Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated documentation files (the
"Software"), to deal in the Software without restriction, including without limitation the rights to use, copy, modify, merge, publish,
distribute, sublicense, and/or sell copies of the Software, and to permit persons to whom the Software is furnished to do so, subject to the
following conditions: The above copyright notice and this permission notice shall be included in all copies or substantial portions of the
Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF
MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY
CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE
OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.
-->
)";

}  // namespace

template <int Dim>
std::string viewer_page(const Scene<Dim>& scene, const std::string& title) {
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>" +
      escaped(title) + "</title>\n<style>\n";
  page.append(embedded::viewer_style).append("</style>\n").append(kNotice).append("</head>\n<body>\n");
  page.append(embedded::viewer_body);
  page += "<script type=\"application/json\" id=\"scene\">" + scene_json(scene, title) + "</script>\n";
  return page.append(embedded::viewer_scripts).append("</body>\n</html>\n");
}

template std::string viewer_page(const Scene<2>&, const std::string&);
template std::string viewer_page(const Scene<3>&, const std::string&);

}  // namespace mapjoin::apps
