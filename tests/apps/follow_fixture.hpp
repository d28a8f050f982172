// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log that is followed while it is written.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <tests/apps/command.hpp>
#include <thread>

namespace mapjoin::testing {

class Follow : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }

  static std::vector<std::string> lines_of(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line + '\n');
    return lines;
  }

  std::vector<nlohmann::json> steps() const {
    std::vector<nlohmann::json> steps;
    for (const auto& line : lines_of(path("steps"))) steps.push_back(nlohmann::json::parse(line));
    return steps;
  }

  /// The lines as a robot would write them: the odometry to each pose, then what it sees. The bundled file has all odometry
  /// first.
  static std::vector<std::string> as_driven(std::vector<std::string> lines) {
    const auto pose = [](const std::string& line) {
      std::istringstream words(line);
      std::string tag;
      int base = -1;
      int target = -1;
      words >> tag >> base >> target;
      return tag == "EDGE_SE2" ? target : tag == "EDGE_SE2_XY" ? base : -1;
    };
    std::stable_sort(lines.begin(), lines.end(), [&](const auto& a, const auto& b) { return pose(a) < pose(b); });
    return lines;
  }

  /// Waits until there are `count` steps, for a minute at most.
  void await_steps(std::size_t count) const {
    for (int k = 0; k < 1200 && lines_of(path("steps")).size() < count; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    ASSERT_GE(lines_of(path("steps")).size(), count);
  }

  TemporaryFolder folder;
  std::vector<std::string> log = as_driven(lines_of(kBundledLog));
};

}  // namespace mapjoin::testing
