// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Pages of maps in headless Chromium.

#include <gtest/gtest.h>

#include <tests/apps/command.hpp>

namespace mapjoin::testing {

using Json = nlohmann::json;

inline const std::string kProbe = content_of(kTestSources / "apps/picture/probe.js");

/// Pages in headless Chromium; skips if it is not installed.
class ViewerPage : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v chromium > /dev/null") != 0) GTEST_SKIP() << "needs chromium, which is not installed";
  }

  std::string path(const std::string& name) const { return (folder.path() / name).string(); }

  std::string page_of(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "plot");
    arguments.insert(arguments.end(), {"-o", path("page.html"), "--quiet"});
    const Ended ended = call(arguments);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return content_of(path("page.html"));
  }

  /// The value of the expression `probe`, a JavaScript object, on the page, and the `errors` of the page.
  Json found_on(std::string page, const std::string& probe, const std::string& graphics = "--use-angle=swiftshader") const {
    const std::string watch =
        "<script>window.problems = []; addEventListener('error', (e) => problems.push(e.message));"
        "console.error = console.warn = (...words) => problems.push(words.join(' '));</script>";
    page.insert(page.find("<body>"), watch);
    page.insert(page.find("</body>"), "<script>" + kProbe + "report(() => (" + probe + "));</script>");
    folder.file("probed.html", page);
    Process process({"chromium", "--headless", "--no-sandbox", graphics, "--enable-unsafe-swiftshader", "--window-size=700,500",
                     "--user-data-dir=" + path("profile"), "--host-resolver-rules=MAP * ~NOTFOUND", "--dump-dom",
                     "file://" + path("probed.html")},
                    {});
    EXPECT_EQ(process.wait(), 0) << process.standard_error();
    const std::string dom = process.standard_output();
    const std::size_t begin = dom.find("[[[", dom.find("id=\"found\""));
    const std::size_t end = dom.find("]]]", begin);
    if (end == std::string::npos) {
      ADD_FAILURE() << "the page did not come to the probe: " << process.standard_error();
      return Json::object();
    }
    std::string text = dom.substr(begin + 3, end - begin - 3);
    for (const auto& [entity, character] : {std::pair("&lt;", "<"), std::pair("&gt;", ">"), std::pair("&amp;", "&")}) {
      for (std::size_t at = text.find(entity); at != std::string::npos; at = text.find(entity)) {
        text.replace(at, std::string(entity).size(), character);
      }
    }
    return Json::parse(text);
  }

  TemporaryFolder folder;
};

/// Poses and features whose ids are not their places in the file, with a closure, far from the origin.
inline const std::string kNamedMap =
    "VERTEX_SE2 10 1000000 5 0\nVERTEX_SE2 20 1000004 5 1.5\nVERTEX_SE2 35 1000004 9 3.1\nVERTEX_SE2 41 1000000 9 -1.6\n"
    "VERTEX_XY 700 1000002 7\nVERTEX_XY 800 1000006 10\n"
    "EDGE_SE2 10 20 4 0 1.5 1 0 0 1 0 1\nEDGE_SE2 20 35 4 0 1.6 1 0 0 1 0 1\nEDGE_SE2 35 41 4 0 1.6 1 0 0 1 0 1\n"
    "EDGE_SE2 41 10 4 0 1.6 1 0 0 1 0 1\nEDGE_SE2_XY 10 700 2 2 1 0 1\nEDGE_SE2_XY 35 800 2 1 1 0 1\n";

}  // namespace mapjoin::testing
