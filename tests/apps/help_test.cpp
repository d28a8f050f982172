// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <apps/commands/subcommand.hpp>
#include <apps/console.hpp>
#include <sstream>
#include <tests/apps/command.hpp>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;

/// The names of all commands, in the order of the help.
std::vector<std::string> command_names() {
  std::vector<std::string> names;
  for (const auto& command : apps::command_line().commands) names.push_back(command->name());
  return names;
}

/// The command lines below "Examples:" of a help text.
std::vector<std::string> examples_in(const std::string& help) {
  std::istringstream lines(help.substr(std::min(help.find("Examples:"), help.size())));
  std::vector<std::string> examples;
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    if (line.starts_with("  ")) examples.push_back(line);
  }
  return examples;
}

/// The examples of a command, one after the other, in a folder with the bundled logs under `data`.
class Examples : public ::testing::TestWithParam<std::string> {};

TEST_P(Examples, WorkAsPasted) {
  const Ended help = call({GetParam(), "--help"});
  ASSERT_EQ(help.exit_code, 0);
  const auto examples = examples_in(help.out);
  ASSERT_FALSE(examples.empty()) << help.out;
  const TemporaryFolder folder;
  fs::create_directory_symlink(kBundledData, folder.path() / "data");
  const std::string path = "export PATH=" + fs::path(kCommand).parent_path().string() + ":$PATH\n";
  for (const std::string& example : examples) {
    Process process({"sh", "-c", path + example}, {folder.path(), {}, false, 0});
    EXPECT_EQ(process.wait(), 0) << example << '\n' << process.standard_error();
    EXPECT_NE(process.standard_output(), "") << example;
  }
}

INSTANTIATE_TEST_SUITE_P(OfEveryCommand, Examples, ::testing::ValuesIn(command_names()),
                         [](const auto& command) { return command.param; });

TEST(Help, NamesEveryCommandAndExitCode) {
  const Ended help = call({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const std::string& name : command_names()) EXPECT_THAT(help.out, ::testing::HasSubstr("\n  " + name + " "));
  const std::string words = apps::wrapped(help.out, help.out.size()).front();
  for (const auto& [code, text, kind] : apps::kExitCodes) {
    EXPECT_THAT(words, ::testing::HasSubstr(fmt::format(" {} {}", static_cast<int>(code), text)));
  }
}

TEST(Help, SaysWhereTheFolderOfARunMayStand) {
  const auto words = [](const std::string& command) {
    const std::string help = call({command, "--help"}).out;
    return apps::wrapped(help, help.size()).front();
  };
  for (const std::string command : {"info", "check", "convert", "basin", "convexity"}) {
    EXPECT_THAT(words(command), ::testing::HasSubstr("A log, the folder of a run, a store, or a folder or archive"));
  }
  for (const std::string command : {"run", "join", "solve", "compare", "plot"}) {
    EXPECT_THAT(words(command), ::testing::HasSubstr(".tum or .csv (poses only), g2o with vertices, or the folder of a run"));
  }
}

TEST(Help, NamesTheVersion) {
  const Ended version = call({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.out, ::testing::MatchesRegex("mapjoin [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

}  // namespace
}  // namespace mapjoin::testing
