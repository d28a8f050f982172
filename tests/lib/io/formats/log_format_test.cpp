// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <tests/support/data.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/random.hpp>
#include <tests/support/same_log.hpp>
#include <tests/support/small_world.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

template <typename Dimension>
class LogFormatTest : public ::testing::Test {
 protected:
  static constexpr int kDim = Dimension::value;

  Log<kDim> world(const WorldOptions& options = {.reversed_odometry = true}) const {
    auto [log, truth] = small_world<kDim>(options);
    log.initial.poses = truth.poses;
    log.initial.features = truth.features;
    return log;
  }
  Log<kDim> again(const Log<kDim>& log, LogFormat format) const {
    const auto path = folder.path() / to_string(format);
    const auto written = write_log(log, format, path);
    if (!written) throw std::runtime_error(written.error().message);
    return std::get<Log<kDim>>(open_log(path).value());
  }
  std::string refusal(const Log<kDim>& log, LogFormat format) const {
    const auto written = write_log(log, format, folder.path() / "refused");
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "refused"));
    return testing::error_of(written);
  }

  TemporaryFolder folder;
};
TYPED_TEST_SUITE(LogFormatTest, Dimensions);

TYPED_TEST(LogFormatTest, G2oBringsBackEveryBit) {
  const auto log = this->world();
  EXPECT_THAT(losses(log, LogFormat::kG2o), ElementsAre("features are numbered from 100 on, apart from poses"));
  auto again = this->again(log, LogFormat::kG2o);
  for (FeatureId& feature : again.features) feature.key -= 100;
  expect_same_log(log, again);
  ASSERT_EQ(again.initial.poses.size(), log.initial.poses.size());
  for (const PoseIndex p : indices(log.poses)) {
    expect_same_value(log.initial.poses[p], again.initial.poses[p], 0.0);
  }
  EXPECT_EQ(again.initial.features, log.initial.features);
}

TYPED_TEST(LogFormatTest, ToroBringsBackAPoseGraphAndItsValues) {
  constexpr int Dim = TypeParam::value;
  const auto log = this->world({.features = 0, .reversed_odometry = true});
  const double rounding = Dim == 2 ? 0.0 : 1e-12;
  const auto again = this->again(log, LogFormat::kToro);
  expect_same_log(log, again, {rounding, rounding});
  for (const PoseIndex p : indices(log.poses)) {
    expect_same_value(log.initial.poses[p], again.initial.poses[p], rounding);
  }
  EXPECT_EQ(losses(log, LogFormat::kToro).size(), Dim == 2 ? 0u : 1u);
}

TYPED_TEST(LogFormatTest, ToroLeavesFeaturesOutAndSaysSo) {
  const auto log = this->world({.features = 10});
  EXPECT_THAT(losses(log, LogFormat::kToro), Contains(HasSubstr("10 features with")));
  EXPECT_TRUE(this->again(log, LogFormat::kToro).features.empty());
}

TYPED_TEST(LogFormatTest, IsamBringsBackEdgesAndObservationsToRounding) {
  const auto log = this->world();
  expect_same_log(log, this->again(log, LogFormat::kIsam), {TypeParam::value == 2 ? 0.0 : 1e-12, 1e-12});
  EXPECT_THAT(losses(log, LogFormat::kIsam), Contains("the values of poses and features are left out"));
}

TYPED_TEST(LogFormatTest, IsamKeepsWhatWasNotMeasured) {
  constexpr int Dim = TypeParam::value;
  auto log = this->world();
  for (auto& o : log.graph.feature_factors) o.information.setZero();
  for (auto& o : log.graph.feature_factors) o.information(Dim - 1, Dim - 1) = 7.0;
  const auto again = this->again(log, LogFormat::kIsam);
  for (const auto& o : again.observations()) {
    EXPECT_NEAR(o.information(Dim - 1, Dim - 1), 7.0, 1e-14);
    EXPECT_TRUE(o.information.row(0).isZero(0.0));
  }
}

TYPED_TEST(LogFormatTest, FurtherSessionsAreNumberedFromAPowerOfTen) {
  const auto log = this->world({.poses = 30, .sessions = 2});
  const auto again = this->again(log, LogFormat::kIsam);
  EXPECT_EQ(again.poses.back(), (PoseId{0, 129}));
  EXPECT_THAT(losses(log, LogFormat::kIsam), Contains("poses of session n are numbered from n times 100 on"));
  EXPECT_EQ(again.sessions.size(), 2u);
}

TYPED_TEST(LogFormatTest, TumBringsBackValuesAndStamps) {
  constexpr int Dim = TypeParam::value;
  auto log = this->world();
  for (const PoseIndex p : indices(log.poses)) {
    log.stamps_ns.push_back(1'600'000'000'123'456'789 + std::int64_t{333'333'333} * p.value);
  }
  const auto again = this->again(log, LogFormat::kTum);
  EXPECT_EQ(again.stamps_ns, log.stamps_ns);
  EXPECT_TRUE(again.odometry().empty());
  for (const PoseIndex p : indices(log.poses)) {
    expect_same_value(log.initial.poses[p], again.initial.poses[p], Dim == 2 ? 1e-14 : 0.0);
  }
  log.stamps_ns.clear();
  EXPECT_TRUE(this->again(log, LogFormat::kTum).stamps_ns.empty());
}

TYPED_TEST(LogFormatTest, KittiBringsBackValues) {
  const auto log = this->world();
  const auto again = this->again(log, LogFormat::kKitti);
  ASSERT_EQ(again.initial.poses.size(), log.poses.size());
  for (const PoseIndex p : indices(log.poses)) {
    expect_same_value(log.initial.poses[p], again.initial.poses[p], 1e-14);
  }
}

TYPED_TEST(LogFormatTest, TellsWhatHasNoPlace) {
  constexpr int Dim = TypeParam::value;
  auto log = this->world({.features = 0});
  log.graph.pose_factors.push_back({kWorld, 0, {}, PoseMatrix<Dim>::Identity()});
  log.graph.fixed.push_back({0, log.initial.poses[0]});
  log.stamps_ns.resize(log.poses.size());
  EXPECT_THAT(losses(log, LogFormat::kG2o), ElementsAre("time stamps are left out"));
  log.graph.pose_factors[0].loss = Loss::truncated(1.0);
  EXPECT_THAT(losses(log, LogFormat::kG2o), ElementsAre("losses of factors are left out", "time stamps are left out"));
  EXPECT_THAT(losses(log, LogFormat::kIsam), Contains("1 prior left out"));
  EXPECT_THAT(losses(log, LogFormat::kToro), Contains("which poses are fixed is left out"));
  EXPECT_EQ(this->again(log, LogFormat::kG2o).graph.fixed.size(), 1u);
}

TYPED_TEST(LogFormatTest, RefusesInASentenceWhatAFormatCannotSay) {
  constexpr int Dim = TypeParam::value;
  auto log = this->world({.features = 0});
  if (Dim == 3) {
    EXPECT_EQ(this->refusal(log, LogFormat::kGtsam), "small world: the format gtsam is for the plane");
    EXPECT_EQ(this->refusal(log, LogFormat::kMat), "small world: the format mat is for the plane");
    auto upright = log;
    upright.graph.pose_factors[4].measured.rotation =
        Rotation<Dim>::exp(RotationVector<Dim>::Unit(Dim == 3 ? 1 : 0) * 0.5 * std::numbers::pi);
    EXPECT_THAT(this->refusal(upright, LogFormat::kIsam),
                HasSubstr("has weights at a pitch of a right angle, which iSAM's files cannot say"));
  } else {
    auto singular = log;
    singular.graph.pose_factors[4].information.setZero();
    for (const LogFormat format : {LogFormat::kGtsam, LogFormat::kOdomObs, LogFormat::kMat}) {
      EXPECT_THAT(this->refusal(singular, format), HasSubstr("has an information matrix that is singular"));
    }
  }
  auto edgeless = log;
  edgeless.graph.pose_factors.clear();
  for (const LogFormat format : {LogFormat::kIsam, LogFormat::kGtsam, LogFormat::kOdomObs, LogFormat::kMat}) {
    if (Dim == 3 && format != LogFormat::kIsam) continue;  // the others are for the plane
    EXPECT_THAT(this->refusal(edgeless, format), HasSubstr("has only edges and observations, and the log has none"));
  }
  EXPECT_EQ(this->again(edgeless, LogFormat::kG2o).poses, edgeless.poses);
  log.initial.poses.clear();
  for (const LogFormat format : {LogFormat::kToro, LogFormat::kTum, LogFormat::kKitti}) {
    EXPECT_THAT(this->refusal(log, format), HasSubstr("needs the values of all poses"));
  }
}

class PlanarFormatTest : public LogFormatTest<std::integral_constant<int, 2>> {};

TEST_F(PlanarFormatTest, CovariancesBringBackInformationToRounding) {
  const Log<2> log = world();
  for (const LogFormat format : {LogFormat::kGtsam, LogFormat::kOdomObs, LogFormat::kMat}) {
    Log<2> again = this->again(log, format);
    if (format == LogFormat::kGtsam) {
      for (FeatureId& feature : again.features) feature.key -= 100;  // numbered apart from poses
    }
    expect_same_log(log, again, {0.0, 1e-12});
  }
}

TEST_F(PlanarFormatTest, MatFilesHaveIdsThatDoublesTellApart) {
  LogBuilder<2> builder("some.g2o");
  builder.add_pose_edge({0, 0}, {0, std::uint64_t{1} << 53}, {}, Matrix<3>::Identity());
  EXPECT_THAT(refusal(std::move(builder).finish().value(), LogFormat::kMat),
              HasSubstr("the edge from pose 0 to pose 9007199254740992 has an id of 2^53 or more"));
  Log<2> singular = world();
  singular.graph.feature_factors[0].information.setZero();
  EXPECT_THAT(refusal(singular, LogFormat::kMat), HasSubstr(": the observation of feature "));
}

TEST(LogFormatData, PublicLogsComeBackFromEveryFormatThatHoldsThem) {
  const TemporaryFolder folder;
  const auto open = [](const std::filesystem::path& path) { return std::get<Log<2>>(open_log(path).value()); };
  const Log<2> vicpark = open(data_file("vicpark-6898/VicPark_clean_data.mat"));
  for (const LogFormat format : {LogFormat::kG2o, LogFormat::kIsam, LogFormat::kGtsam, LogFormat::kOdomObs, LogFormat::kMat}) {
    ASSERT_TRUE(write_log(vicpark, format, folder.path() / "log"));
    Log<2> again = open(folder.path() / "log");
    // g2o and GTSAM number features apart from poses.
    if (format == LogFormat::kG2o || format == LogFormat::kGtsam) again.features = vicpark.features;
    expect_same_log(vicpark, again, {0.0, format == LogFormat::kG2o ? 0.0 : 1e-12});
  }
  // The authors' own table, with covariances to rounding.
  ASSERT_TRUE(write_log(vicpark, LogFormat::kOdomObs, folder.path() / "log"));
  expect_same_log(open(data_file("vicpark-6898/vicpark_clean_data.txt.gz")), open(folder.path() / "log"), {0.0, 1e-12});
}

TEST(LogFormats, AToroFileWithoutVerticesIsSuspectedByItsWeights) {
  const TemporaryFolder folder;
  const auto file = folder.file("log", "EDGE2 1 0 1 2 0.5 20 0 20 100 0 0\n");
  EXPECT_THAT(open_log(file).error().message, HasSubstr(":1:33: these weights are singular as iSAM's square root, and sound as "
                                                        "TORO's information matrix; --from toro"));
  const auto weights = [&](LogFormat format) {
    return Vector<3>(std::get<Log<2>>(open_log(file, {.from = format}).value()).odometry()[0].information.diagonal());
  };
  EXPECT_EQ(weights(LogFormat::kToro), Vector<3>(20, 20, 100));
  EXPECT_EQ(weights(LogFormat::kIsam), Vector<3>(400, 10000, 400));
  const auto unmeasured = folder.file("isam", "EDGE2 0 1 1 2 0.5 20 0 0 20 0 0\n");
  EXPECT_TRUE(open_log(unmeasured)) << "a heading that was not measured";
}

TEST(LogFormats, AFormatIsKnownBehindLinesThatMayBeLeftOut) {
  const TemporaryFolder folder;
  const auto file = folder.file("log", "hello\n\nEDGE_SE2 0 1 1 0 0.1 1 0 0 1 0 1\n");
  EXPECT_THAT(open_log(file).error().message, HasSubstr("no log format has lines that begin with 'hello'; --skip-unknown"));
  const auto log = std::get<Log<2>>(open_log(file, {.skip_unknown = true}).value());
  EXPECT_EQ(log.skipped, (SkipCounts{{"hello lines", 1}}));
  const std::string pose = "1 2 3 0 0 0 1\n";
  const auto table = folder.file("table", "time x y\n\n0.5 " + pose + "noon " + pose);
  EXPECT_THAT(open_log(table).error().message, HasSubstr("'time'; --skip-unknown leaves the lines before the table out, "));
  EXPECT_THAT(open_log(table, {.skip_unknown = true}).error().message, HasSubstr("table:4:1: a time in seconds is expected"));
  const auto trajectory = folder.file("trajectory", "time x y\ntime is in seconds\n0.5 " + pose);
  const auto poses = std::get<Log<3>>(open_log(trajectory, {.skip_unknown = true}).value());
  EXPECT_EQ(poses.poses.size(), 1U);
  EXPECT_EQ(poses.skipped, (SkipCounts{{"time lines", 2}}));
  EXPECT_TRUE(open_log(trajectory, {.from = LogFormat::kTum, .skip_unknown = true}));
  const auto nothing = folder.file("nothing", "hello\nworld");
  for (const bool skip : {false, true}) {
    EXPECT_THAT(open_log(nothing, {.skip_unknown = skip}).error().message,
                EndsWith("nothing:1:1: no log format has lines that begin with 'hello'; --from names the format"))
        << "for nothing would be left";
  }
}

TEST(LogFormats, AFormatIsKnownByLinesWithoutAPlaceInTheLog) {
  const std::string edge = "EDGE_SE2 0 1 1 0 0.1 1 0 0 1 0 1\n";
  for (const std::string first : {"ROBOTLASER1 0 1 2\n", "VERTEX_TAG 0 17\n"}) {
    EXPECT_THAT(std::get<Log<2>>(read_log(first + edge, "log", {}).value()).edges(), SizeIs(1)) << first;
  }
  const auto toro = read_log("EQUIV 0 1\nVERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 1 0 0 1 0 1 1 0 0\n", "log", {});
  EXPECT_EQ(std::get<Log<2>>(toro.value()).skipped, (SkipCounts{{"EQUIV lines", 1}}));
}

TEST(LogFormats, OnlyTheFirstOfManyTagsAreTold) {
  std::string text = "EDGE_SE2 0 1 1 0 0.1 1 0 0 1 0 1\nEDGE_SE2 1 1 1 0 0.1 1 0 0 1 0 1\n" + std::string(1000, 'A') + "\n";
  for (int k = 10; k < 40; ++k) text += fmt::format("TAG{} 1\nTAG{} 2\n", k, k);
  const auto any = read_log(text, "log", {.skip_unknown = true, .skip_self_edges = true});
  const SkipCounts skipped = std::get<Log<2>>(any.value()).skipped;
  EXPECT_THAT(skipped, SizeIs(22));
  EXPECT_EQ(skipped.at(std::string(40, 'A') + "... lines"), 1);
  EXPECT_EQ(skipped.at("TAG28 lines"), 2);
  EXPECT_EQ(skipped.at("other lines"), 22);
  EXPECT_EQ(skipped.at("self-edges"), 1);
}

TEST(LogFormats, AFormatIsKnownInAFewPassesOverTheFile) {
  constexpr int kLines = 100'000;
  std::string edges;
  for (int k = 0; k < kLines; ++k) edges += fmt::format("EDGE2 {} {} 1 0 0 1 0 1 1 0 0\n", k, k + 1);
  const std::string blanks(kLines, '\n');
  const EffortMeter meter;
  const auto toro = read_log(edges, "toro", {.from = LogFormat::kToro, .skip_unknown = true});
  EXPECT_THAT(std::get<Log<2>>(toro.value()).edges(), SizeIs(kLines));
  EXPECT_THAT(read_log("hello" + blanks + "world", "nothing", {}).error().message, StartsWith("nothing:1:1: no log format"));
  EXPECT_LT(meter.so_far().cpu_seconds, 20.0) << "a pass for every line takes minutes";
}

}  // namespace
}  // namespace mapjoin::testing
