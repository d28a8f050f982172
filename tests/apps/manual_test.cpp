// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>
#include <tests/apps/command.hpp>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const fs::path kCompletion = kDocuments.parent_path() / "apps" / "manual";

bool is_installed(const std::string& program) {
  return Process({"sh", "-c", "command -v " + program}).wait() == 0;
}

std::string output_of(const std::vector<std::string>& words) {
  Process process(words);
  EXPECT_EQ(process.wait(), 0) << process.standard_error();
  return process.standard_output();
}

/// The names of all commands, as `mapjoin --help` lists them.
std::vector<std::string> commands() {
  const std::string help = call({"--help"}).out;
  const std::regex line("\n  ([a-z]+)  ");
  std::vector<std::string> names;
  for (auto match = std::sregex_iterator(help.begin() + static_cast<long>(help.find("Commands:")), help.end(), line);
       match != std::sregex_iterator(); ++match)
    names.push_back((*match)[1]);
  return names;
}

std::set<std::string> long_options_in(const std::string& text) {
  const std::regex option("--[a-z0-9][a-z0-9-]+");
  return {std::sregex_token_iterator(text.begin(), text.end(), option), std::sregex_token_iterator()};
}

std::set<fs::path> page_names_in(const fs::path& folder) {
  std::set<fs::path> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
  return names;
}

TEST(Manual, ThePagesOfCommandsAreThoseThatTheBuildMakes) {
  const std::string remedy = "`cmake --build --preset test --target command_pages` makes them anew";
  const fs::path pages = kDocuments / "commands";
  EXPECT_EQ(page_names_in(pages), page_names_in(kManual / "commands")) << remedy;
  for (const fs::path& page : page_names_in(pages)) {
    EXPECT_EQ(content_of(pages / page), content_of(kManual / "commands" / page)) << page << ": " << remedy;
  }
}

TEST(Manual, APageOfACommandHoldsItsHelp) {
  ASSERT_GE(commands().size(), 10u);
  for (const std::string& name : commands()) {
    EXPECT_THAT(content_of(kManual / "commands" / (name + ".md")), HasSubstr("--help\n" + call({name, "--help"}).out + "```"));
  }
}

TEST(Manual, EveryOptionIsInItsManPage) {
  if (!is_installed("mandoc")) GTEST_SKIP() << "mandoc is not installed";
  for (const std::string& name : commands()) {
    const std::string page = (kManual / "man1" / ("mapjoin-" + name + ".1")).string();
    EXPECT_EQ(output_of({"mandoc", "-T", "lint", "-W", "error", page}), "");
    const auto shown = long_options_in(output_of({"mandoc", "-T", "html", page}));
    for (const std::string& option : long_options_in(call({name, "--help"}).out)) EXPECT_TRUE(shown.contains(option)) << option;
  }
}

/// The words that bash offers for the last of `words`, or the options by which it asks readline to complete.
std::vector<std::string> offered_by_bash(const std::vector<std::string>& words) {
  std::vector<std::string> line = {"bash", "-c",
                                   "source $0; compopt() { echo compopt $2; }; COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1))\n"
                                   "_mapjoin; for word in \"${COMPREPLY[@]}\"; do echo $word; done",
                                   (kCompletion / "completion.bash").string(), kCommand};
  line.insert(line.end(), words.begin(), words.end());
  std::istringstream out(output_of(line));
  std::vector<std::string> offered;
  for (std::string word; std::getline(out, word);) offered.push_back(word);
  return offered;
}

TEST(BashCompletion, OffersCommandsOptionsAndTheirValues) {
  EXPECT_THAT(offered_by_bash({"convex"}), ElementsAre("convexity"));
  EXPECT_THAT(offered_by_bash({"run", "--poses"}), ElementsAre("--poses-per-map"));
  EXPECT_THAT(offered_by_bash({"run", "--state", ""}), ElementsAre("absolute", "relative"));
  EXPECT_THAT(offered_by_bash({"run", "--poses-per-map", ""}), ElementsAre("auto"));
  EXPECT_THAT(offered_by_bash({"run", "--jobs", ""}), ElementsAre());
  EXPECT_THAT(offered_by_bash({"run", "-o", ""}), ElementsAre("compopt default"));
  EXPECT_THAT(offered_by_bash({"compare", "-o", ""}), ElementsAre("compopt dirnames"));
  EXPECT_THAT(offered_by_bash({"run", ""}), ElementsAre("compopt default"));
}

TEST(BashCompletion, KnowsEveryOption) {
  for (const std::string& name : commands()) {
    const std::string help = call({name, "--help"}).out;
    const auto offered = offered_by_bash({name, "--"});
    EXPECT_FALSE(offered.empty());
    for (const std::string& option : long_options_in(help.substr(0, help.find("Examples:")))) {
      EXPECT_TRUE(std::find(offered.begin(), offered.end(), option) != offered.end()) << name << ' ' << option;
    }
  }
}

/// The text that a terminal shows after the line and a tab, once it matches the pattern `expected`.
std::string shown_by_zsh(const std::string& line, const std::string& expected) {
  const std::string script = "path=(" + fs::path(kCommand).parent_path().string() +
                             " $path); zmodload zsh/zpty; zpty shell zsh -f -i\n"
                             "zpty -w shell \"fpath=($0 \\$fpath); autoload -U compinit; compinit -u -D; echo rea''dy\"\n"
                             "zpty -r -m shell seen '*ready*'\n"
                             "zpty -w -n shell $'" +
                             line +
                             "\\t'\n"
                             "zpty -r -m shell seen '" +
                             expected + "'; print -r -- $seen; zpty -d shell\n";
  return output_of({"timeout", "60", "zsh", "-f", "-c", script, kCompletion.string()});
}

TEST(ZshCompletion, OffersCommandsOptionsAndTheirValues) {
  if (!is_installed("zsh")) GTEST_SKIP() << "zsh is not installed";
  EXPECT_THAT(shown_by_zsh("mapjoin ", "*basin*simulate*"), HasSubstr("From a log to a global map"));
  EXPECT_THAT(shown_by_zsh("mapjoin run --rel", "*--relations*"), HasSubstr("--relations"));
  EXPECT_THAT(shown_by_zsh("mapjoin run --state ", "*absolute*relative*"), HasSubstr("relative"));
}

}  // namespace
}  // namespace mapjoin::testing
