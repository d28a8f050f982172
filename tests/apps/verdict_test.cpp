// SPDX-License-Identifier: BSD-3-Clause
// The verdict of the command: whether a map fits.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <tests/apps/command.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class VerdictTest : public ::testing::Test {
 protected:
  /// The bundled log with a further line.
  std::string log_with(const std::string& line) const {
    const std::string path = (folder.path() / "log.g2o").string();
    std::ofstream(path) << content_of(kBundledLog) << line << '\n';
    return path;
  }
  TemporaryFolder folder;
  const std::string wrong_closure = "EDGE_SE2 10 700 1 0 0 400 0 0 400 0 400";
};

TEST_F(VerdictTest, IsALineOfTheSummaryAndAKeyOfTheReport) {
  const std::string log = kBundledLog;
  EXPECT_THAT(call({"run", log}).out,
              HasSubstr("\nverdict      fits: nothing is out of line among 3522 measurements tested\n"));
  const auto report = report_of({"run", log});
  EXPECT_EQ(report["verdict"], "fits");
  EXPECT_EQ(report["misfits"].size(), 0U);
  EXPECT_EQ(report["fit"]["parts"], 3522);
  EXPECT_EQ(report["fit"]["complete"], true);
}

TEST_F(VerdictTest, NamesAWrongClosureByItsIds) {
  const std::string log = log_with(wrong_closure);
  for (const std::string command : {"run", "solve"}) {
    const auto report = report_of({command, log});
    EXPECT_EQ(report["verdict"], "misfit");
    const auto& worst = report["misfits"].at(0);
    EXPECT_EQ(worst["kind"], "closure");
    EXPECT_EQ(worst["from"]["pose"], 10);
    EXPECT_EQ(worst["to"]["pose"], 700);
    EXPECT_LT(worst["probability"], 1e-6);
  }
  const std::string maps = (folder.path() / "log.maps").string();
  ASSERT_EQ(call({"build", log, "-o", maps, "--quiet"}).exit_code, 0);
  EXPECT_EQ(report_of({"join", maps})["misfits"].at(0)["kind"], "closure");
}

TEST_F(VerdictTest, DecidesTheExitCodeOnlyWhereThatIsStrict) {
  const std::string log = log_with(wrong_closure);
  EXPECT_EQ(call({"run", log, "--quiet"}).exit_code, 0);
  const std::string map = (folder.path() / "map.g2o").string();
  const Ended strict = call({"run", log, "--quiet", "--strict", "-o", map});
  EXPECT_EQ(strict.exit_code, 7);
  EXPECT_THAT(strict.err, HasSubstr("MISFIT: closure from pose 10 to pose 700"));
  EXPECT_THAT(strict.err, HasSubstr("; the map is written all the same"));
  EXPECT_TRUE(std::filesystem::exists(map));
  EXPECT_EQ(call({"run", kBundledLog, "--quiet", "--strict"}).exit_code, 0);
}

TEST_F(VerdictTest, IsUntestedWhereNothingIsMeasuredTwiceOrNobodyAsks) {
  const std::string path = (folder.path() / "line.g2o").string();
  std::ofstream(path) << "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n";
  const Ended line = call({"run", path, "--strict"});
  EXPECT_EQ(line.exit_code, 7);
  EXPECT_THAT(line.out, HasSubstr("\nverdict      untested: nothing is measured twice\n"));
  const auto report = report_of({"run", log_with(wrong_closure), "--no-verdict"});
  EXPECT_EQ(report["verdict"], "untested");
  EXPECT_TRUE(report["fit"]["parts"].is_null());
  const Ended both = call({"run", path, "--strict", "--no-verdict"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_THAT(both.err, HasSubstr("--strict goes by the verdict, which --no-verdict leaves out"));
}

TEST_F(VerdictTest, ShowsTheFiveWorstForPeople) {
  std::string lines;
  for (const int pose : {10, 110, 210, 310, 410, 510, 610}) {
    lines += fmt::format("EDGE_SE2 {} {} 1 0 0 25 0 0 25 0 25\n", pose, pose + 4);
  }
  const std::string out = call({"run", log_with(lines)}).out;
  EXPECT_THAT(out, HasSubstr(" and 6 more are out of line with the rest\n"));
  std::size_t shown = 0;
  for (std::size_t at = out.find("closure from"); at != std::string::npos; at = out.find("closure from", at + 1)) ++shown;
  EXPECT_EQ(shown, 5U);
}

TEST_F(VerdictTest, SaysThatMoreMayShowWithoutWhatBentTheMap) {
  EXPECT_THAT(call({"run", log_with(wrong_closure)}).out,
              HasSubstr(" is out of line with the rest; more may show without it\n"));
}

TEST_F(VerdictTest, SaysWhatLooksForWhatIsWrong) {
  const std::string log = log_with(wrong_closure);
  const std::string looks = "` looks for what contradicts the most, and leaves it out\n";
  EXPECT_THAT(call({"run", log}).out, HasSubstr(": `mapjoin run LOG --robust" + looks));
  EXPECT_THAT(call({"run", log, "--robust"}).out, Not(HasSubstr(looks)));
  EXPECT_THAT(call({"run", kBundledLog}).out, Not(HasSubstr(looks)));
  const std::string slip = (folder.path() / "slip.g2o").string();
  std::ofstream edges(slip);
  for (const auto& [from, to, measured] :
       {std::tuple{0, 1, 1}, {1, 2, 1}, {2, 3, 6}, {3, 4, 1}, {0, 3, 3}, {0, 4, 4}, {1, 4, 3}}) {
    edges << fmt::format("EDGE_SE2 {} {} {} 0 0 1e4 0 0 1e4 0 1e4\n", from, to, measured);
  }
  edges.close();
  EXPECT_THAT(call({"run", slip}).out, HasSubstr(": `mapjoin run LOG --robust=all" + looks));
}

TEST_F(VerdictTest, SaysThatRobustJoiningGoesByCovariancesThatAreTooSmall) {
  const std::string path = (folder.path() / "noisy.g2o").string();
  const std::string note = "note         --robust judges by covariances that are too small";
  for (const std::string multiplier : {"1", "3"}) {
    ASSERT_EQ(call({"simulate", "--poses", "500", "--noise-multiplier", multiplier, "-o", path, "--quiet"}).exit_code, 0);
    std::ofstream(path, std::ios::app) << "EDGE_SE2 10 400 1 0 0 25 0 0 25 0 25\n";
    EXPECT_EQ(call({"run", path, "--robust"}).out.find(note) != std::string::npos, multiplier == "3");
    EXPECT_THAT(call({"run", path}).out, Not(HasSubstr(note)));
  }
}

TEST_F(VerdictTest, SaysByHowMuchCovariancesAreTooSmall) {
  const std::string path = (folder.path() / "noisy.g2o").string();
  ASSERT_EQ(call({"simulate", "--poses", "500", "--noise-multiplier", "3", "-o", path, "--quiet"}).exit_code, 0);
  EXPECT_THAT(call({"run", path}).out, HasSubstr("typical residuals are larger than the covariances say: "));
  std::ofstream(path, std::ios::app) << "EDGE_SE2 10 400 1 0 0 25 0 0 25 0 25\n";
  const std::string said = "typical residuals are larger than the covariances say: ";
  EXPECT_THAT(call({"run", path}).out, AllOf(HasSubstr("MISFIT: closure from pose 10 to pose 400"), HasSubstr(said)));
  EXPECT_THAT(call({"check", path}).out,
              AllOf(HasSubstr("warning      out of line with the rest: 1 of "), HasSubstr("warning      " + said)));
}

TEST_F(VerdictTest, NamesTheFactorsByWhichCovariancesFit) {
  const std::string path = (folder.path() / "noisy.g2o").string();
  const std::string option = "`mapjoin run LOG --inflate ";
  for (const auto& [poses, multiplier] : {std::pair("500", "3"), {"2000", "1.34"}}) {
    ASSERT_EQ(call({"simulate", "--poses", poses, "--noise-multiplier", multiplier, "-o", path, "--quiet"}).exit_code, 0);
    const std::string said = call({"run", path}).out;
    const std::size_t at = said.find("note         " + option);
    ASSERT_NE(at, said.npos) << said;
    const std::size_t begin = said.find(option, at) + option.size();
    const std::string factors = said.substr(begin, said.find('`', begin) - begin);
    EXPECT_THAT(call({"check", path}).out, HasSubstr("; " + option + factors));
    const auto inflated = call({"run", path, "--inflate", factors});
    EXPECT_THAT(inflated.out, AllOf(HasSubstr("verdict      fits"), HasSubstr(", inflated odometry "), Not(HasSubstr(option))));
  }
}

TEST_F(VerdictTest, InflatedCovariancesAreGoodForRobustJoining) {
  const std::string path = (folder.path() / "noisy.g2o").string();
  ASSERT_EQ(call({"simulate", "--poses", "500", "--noise-multiplier", "3", "-o", path, "--quiet"}).exit_code, 0);
  const auto rejected = [&](const std::vector<std::string>& words) {
    return report_of(words)["robust"]["rejected"].get<int>();
  };
  EXPECT_GT(rejected({"run", path, "--robust"}), 10);
  EXPECT_EQ(rejected({"run", path, "--robust", "--inflate", "odometry=3.2,observation=2.95"}), 0);
}

}  // namespace
}  // namespace mapjoin::testing
