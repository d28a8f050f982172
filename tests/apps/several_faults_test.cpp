// SPDX-License-Identifier: BSD-3-Clause
// Several logs or stores in one call that do not go together.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tests/apps/several_inputs.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// The second robot begins a metre on, and its prior, too, says that it begins at the origin.
TEST_F(SeveralInputs, PriorsOfFramesOfTheirOwnAreSuspected) {
  const std::string prior = "EDGE_PRIOR_SE2 0 0 0 0 10000 0 0 10000 0 10000\n";
  const auto log = [&](double x) {
    std::string text = "EDGE_SE2 0 1 1 0 0 10000 0 0 10000 0 10000\n";
    for (const int pose : {0, 1}) {
      text += fmt::format("EDGE_SE2_XY {} 7 {} 1 10000 0 10000\nEDGE_SE2_XY {} 8 {} -1 10000 0 10000\n", pose, 2 - x - pose,
                          pose, 2 - x - pose);
    }
    return text;
  };
  const std::string first = folder.file("first.g2o", prior + log(0)).string();
  const std::string second = folder.file("second.g2o", prior + log(1)).string();
  const std::string note = "the priors of all inputs are of one World: if those of each are in a frame of its own";
  const Ended both = call({"run", first, second});
  EXPECT_THAT(both.out, HasSubstr("MISFIT: prior of pose 0"));
  EXPECT_THAT(both.out, HasSubstr(note));
  const Ended one = call({"run", first, folder.file("second.g2o", log(1)).string()});
  EXPECT_THAT(one.out, HasSubstr("verdict      fits"));
  EXPECT_THAT(one.out, Not(HasSubstr(note)));
}

TEST_F(SeveralInputs, ACopyIsRefusedWhateverItsName) {
  const std::string copy = (folder.path() / "copy.g2o").string();
  std::filesystem::copy_file(a, copy);
  const std::string is_copy = copy + " has the same poses, features and measurements as " + a;
  for (const char* command : {"run", "check", "build"}) {
    const Ended ended = call({command, a, b, copy, "-o", (folder.path() / "out").string()});
    EXPECT_EQ(ended.exit_code, 2) << command;
    EXPECT_THAT(ended.err, HasSubstr(is_copy)) << command;
    EXPECT_THAT(ended.err, HasSubstr("leave one out; --keep-copies takes both for robots")) << command;
  }
  EXPECT_EQ(report_of({"solve", a, copy, "--keep-copies"})["poses"], 1000);

  const std::string store = (folder.path() / "a.maps").string();
  ASSERT_EQ(call({"build", a, "-o", store, "--poses-per-map", "25"}).exit_code, 0);
  std::vector<std::string> sets;
  for (const char* name : {"set", "same"}) {
    sets.push_back((folder.path() / name).string());
    ASSERT_EQ(call({"convert", store, sets.back(), "--to", "maps-mat"}).exit_code, 0);
  }
  const Ended ended = call({"join", sets[0], sets[1]});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err, HasSubstr(sets[1] + " has the same poses, features and measurements as " + sets[0]));
  EXPECT_EQ(report_of({"join", sets[0], sets[1], "--keep-copies"})["local_maps"]["count"],
            2 * report_of({"join", sets[0]})["local_maps"]["count"].get<int>());
}

TEST_F(SeveralInputs, OneOfThemMayNotBeLocalMaps) {
  EXPECT_THAT(call({"run", a, folder.path().string()}).err, HasSubstr("`mapjoin join` takes"));
  EXPECT_EQ(call({"run", a, b, "--follow"}).exit_code, 2);
}

TEST_F(SeveralInputs, AnOutputIsNoneOfThem) {
  EXPECT_THAT(call({"run", a, b, "-o", b}).err, HasSubstr("FURTHER and --output are one file"));
}

}  // namespace
}  // namespace mapjoin::testing
