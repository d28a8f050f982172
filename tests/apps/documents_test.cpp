// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <apps/exit_code.hpp>
#include <cctype>
#include <iostream>
#include <set>
#include <tests/apps/command.hpp>
#include <tests/apps/documents.hpp>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;

const fs::path kDocs = kDocuments;

/// README.md, data/README.md and every page of docs/.
std::vector<fs::path> pages() {
  std::vector<fs::path> all = {kDocs.parent_path() / "README.md", kBundledData / "README.md"};
  for (const auto& entry : fs::recursive_directory_iterator(kDocs)) {
    if (entry.path().extension() == ".md") all.push_back(entry.path());
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// The reason why a block is not run; nullopt if it is run.
std::optional<std::string> left_out(const Block& block) {
  if (block.not_run) return block.not_run;
  if (!block.data.empty() && std::getenv("MAPJOIN_DATA_DIR") == nullptr) return "MAPJOIN_DATA_DIR is not set";
  return std::nullopt;
}

/// A folder as a reader of the documents has it: the bundled logs in data/, the programs of the library guide, and the command
/// on the PATH.
class Reader {
 public:
  Reader() {
    fs::create_directory_symlink(kBundledData, folder_.path() / "data");
    fs::create_directory(folder_.path() / "build");
    for (const auto& program : fs::directory_iterator(kExamples)) {
      fs::create_symlink(program.path(), folder_.path() / program.path().filename());
    }
  }

  void run(const Block& block) const {
    for (const fs::path file : block.data) {
      const fs::path link = folder_.path() / file.filename();
      if (!fs::exists(link)) fs::create_symlink(fs::path(std::getenv("MAPJOIN_DATA_DIR")) / file, link);
    }
    block.language == "sh" ? run_script(block) : run_console(block);
  }

 private:
  /// The lines before each script: the folder of the command on the PATH, and all output in one stream, as a terminal shows it.
  std::string prelude() const { return "exec 2>&1; export PATH=" + fs::path(kCommand).parent_path().string() + ":$PATH\n"; }

  std::string output_of(const std::string& script, int& exit_code) const {
    Process process({"bash", "-c", prelude() + script}, {folder_.path(), {}, false, 0});
    exit_code = process.wait();
    return process.standard_output();
  }

  void run_script(const Block& block) const {
    std::string script = "set -e\n";
    for (const std::string& line : block.lines) script += line + '\n';
    int exit_code = -1;
    const std::string output = output_of(script, exit_code);
    EXPECT_EQ(exit_code, 0) << "line " << block.line << '\n' << output;
  }

  void run_console(const Block& block) const {
    const std::vector<Shown> all = shown_in(block);
    ASSERT_FALSE(all.empty()) << "line " << block.line << " has no command";
    std::string script;
    for (const Shown& shown : all) script += shown.command + "\nstatus=$?; printf '\\036'; (exit $status)\n";
    int exit_code = -1;
    std::istringstream outputs(output_of(script, exit_code));
    if (block.exit) {
      EXPECT_EQ(std::to_string(exit_code), *block.exit) << "line " << block.line;
    }
    for (const Shown& shown : all) {
      std::string output;
      std::getline(outputs, output, '\036');
      const auto differs = difference(shown.output, lines_of(output));
      EXPECT_FALSE(differs) << "below line " << block.line << ", $ " << shown.command << '\n'
                            << *differs << "\nall of it:\n"
                            << output;
    }
  }

  TemporaryFolder folder_;
};

std::string name_of(const fs::path& page) {
  std::string name = page.lexically_relative(kDocs.parent_path()).replace_extension().string();
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
}

class Page : public ::testing::TestWithParam<fs::path> {};

TEST_P(Page, GivesWhatItShows) {
  const Reader reader;
  for (const Block& block : blocks_of(GetParam())) {
    if (block.holds_commands() && !left_out(block)) reader.run(block);
  }
}

TEST_P(Page, HasItsCommandsInBlocksThatAreRun) {
  const auto lines = lines_of(content_of(GetParam()));
  std::set<std::string> in_blocks;
  for (const Block& block : blocks_of(GetParam())) {
    if (block.holds_commands()) in_blocks.insert(block.lines.begin(), block.lines.end());
  }
  const std::regex command(R"(^ *(\$ |\./dev |mapjoin [a-z]+ ).*)");
  for (const std::string& line : lines) {
    if (std::regex_match(line, command) && line.find('`') == std::string::npos) {
      EXPECT_TRUE(in_blocks.contains(line)) << line;
    }
  }
}

TEST_P(Page, LinksToWhatThereIs) {
  const std::string text = content_of(GetParam());
  const std::regex link(R"(\]\(([^)#: ]+)(#[^)]*)?\))");
  for (std::sregex_iterator match(text.begin(), text.end(), link); match != std::sregex_iterator(); ++match) {
    EXPECT_TRUE(fs::exists(GetParam().parent_path() / match->str(1))) << match->str();
  }
}

TEST_P(Page, ShowsProgramsAsTheyAreCompiled) {
  for (const Block& block : blocks_of(GetParam())) {
    if (!block.file) continue;
    auto lines = lines_of(content_of(GetParam().parent_path() / *block.file));
    ASSERT_FALSE(lines.empty()) << *block.file;
    lines.erase(lines.begin());
    EXPECT_EQ(block.lines, lines) << *block.file;
  }
}

TEST_P(Page, NamesOptionsThatThereAre) {
  const std::string text = content_of(GetParam());
  const std::regex command("`mapjoin ([a-z]+) ([^`]*)`");
  const std::regex option("--[a-z0-9][a-z0-9-]+");
  for (std::sregex_iterator match(text.begin(), text.end(), command); match != std::sregex_iterator(); ++match) {
    const std::string words = (*match)[2];
    const Ended help = call({(*match)[1], "--help"});
    EXPECT_EQ(help.exit_code, 0) << match->str();
    for (std::sregex_iterator name(words.begin(), words.end(), option); name != std::sregex_iterator(); ++name) {
      EXPECT_THAT(help.out, ::testing::HasSubstr(name->str())) << match->str();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Documents, Page, ::testing::ValuesIn(pages()), [](const auto& page) { return name_of(page.param); });

TEST(Documents, SayWhichCommandsAreNotRun) {
  for (const fs::path& page : pages()) {
    for (const Block& block : blocks_of(page)) {
      const auto reason = left_out(block);
      if (!block.holds_commands() || !reason) continue;
      EXPECT_NE(*reason, "") << page;
      std::cout << "not run: " << name_of(page) << ':' << block.line << ": " << *reason << '\n';
    }
  }
}

TEST(Documents, TheGuideListsEveryExitCode) {
  const std::string guide = content_of(kDocs / "guide.md");
  for (const auto& [code, text, kind] : apps::kExitCodes) {
    EXPECT_THAT(guide, ::testing::HasSubstr("\n| " + std::to_string(static_cast<int>(code)) + " | ")) << text;
  }
}

TEST(Documents, AComparisonNoticesWhatDiffers) {
  EXPECT_FALSE(difference({"chi2 4702.179445", "…", "end"}, {"chi2  4702.179446", "a", "b", "end"}));
  EXPECT_FALSE(difference({"seconds 0.10: read 0.00; 24 MB at most"}, {"seconds 12.30: read 1.00; 9 MB at most"}));
  EXPECT_TRUE(difference({"chi2 4702.179445"}, {"chi2 4703.179445"}));
  EXPECT_TRUE(difference({"1000 poses"}, {"1001 poses"}));
  EXPECT_TRUE(difference({"features 0.1 m relative"}, {"features 0.059 m relative"}));
  EXPECT_TRUE(difference({"would take 1.53 MB"}, {"would take 1.55 MB"}));
  EXPECT_TRUE(difference({"a"}, {"a", "b"}));
  EXPECT_TRUE(difference({"a", "b"}, {"a"}));
  EXPECT_TRUE(difference({"a", "…", "c"}, {"a", "b"}));
}

}  // namespace
}  // namespace mapjoin::testing
