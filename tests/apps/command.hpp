// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Calls of the command, the logs that tests give it, and readers of what it writes.

#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <tests/support/places.hpp>
#include <tests/support/process.hpp>
#include <utility>
#include <vector>

namespace mapjoin::testing {

/// The end of a call of the command.
struct Ended {
  int exit_code = -1;
  std::string out;
  std::string err;
};

inline std::vector<std::string> command_line(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), kCommand);
  return arguments;
}

inline Ended call(std::vector<std::string> arguments, const ProcessOptions& options = {}) {
  Process process(command_line(std::move(arguments)), options);
  const int exit_code = process.wait();
  return {exit_code, process.standard_output(), process.standard_error()};
}

/// The report of a call, to which `--report -` is added.
inline nlohmann::json report_of(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--report", "-"});
  const Ended ended = call(std::move(arguments));
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  return nlohmann::json::parse(ended.out);
}

/// The fields of a line of a table without quotes.
inline std::vector<std::string> fields_of(const std::string& line) {
  std::istringstream stream(line + ",");
  std::vector<std::string> fields;
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

inline std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Expects one sentence with `part` in it on standard error, after the name of the command, and nothing on standard output.
inline void expect_failure(const Ended& ended, int exit_code, const std::string& part) {
  EXPECT_EQ(ended.exit_code, exit_code);
  EXPECT_EQ(ended.out, "");
  EXPECT_THAT(ended.err, ::testing::AllOf(::testing::StartsWith("mapjoin: "), ::testing::HasSubstr(part)));
  EXPECT_EQ(lines_of(ended.err).size(), 1U) << ended.err;
}

/// The number of times that `part` is in `text`.
inline std::size_t count_of(std::string_view text, std::string_view part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string_view::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// The bundled log of the demonstration, and its true poses.
inline const std::string kBundledLog = (kBundledData / "manhattan2d.g2o").string();
inline const std::string kBundledTruth = (kBundledData / "manhattan2d.truth.tum").string();

/// Three poses in a row, the first and the last of which see one feature.
inline const std::string kSmallLog =
    "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
    "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n"
    "EDGE_SE2_XY 0 7 2 1 1 0 1\n"
    "EDGE_SE2_XY 2 7 0 1.1 1 0 1\n";

}  // namespace mapjoin::testing
