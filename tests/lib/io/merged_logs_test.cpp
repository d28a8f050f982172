// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/merged_logs.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <string>
#include <tests/support/error_of.hpp>
#include <vector>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

const std::string kNumbers = " 1 0 0 1 0 0 1 0 1\n";

Log<2> log_of(const std::string& name, const std::string& text) {
  return std::get<Log<2>>(read_g2o(TextScanner(name, text), {.undeclared = Undeclared::kForeign}).value());
}

std::string vertices(std::uint64_t first, int count) {
  std::string text;
  for (int k = 0; k < count; ++k) text += "VERTEX_SE2 " + std::to_string(first + static_cast<std::uint64_t>(k)) + " 0 0 0\n";
  return text;
}
std::string edge(std::uint64_t base, std::uint64_t target) {
  return "EDGE_SE2 " + std::to_string(base) + " " + std::to_string(target) + kNumbers;
}

TEST(MergedLogs, KeepTheirOwnNamesOfPosesAndShareThoseOfFeatures) {
  const auto log = merged<2>({log_of("a", edge(0, 1) + "EDGE_SE2_XY 1 7 1 0 1 0 1\n"),
                              log_of("b", edge(0, 1) + "EDGE_SE2_XY 0 7 1 0 1 0 1\nEDGE_SE2_XY 0 8 1 0 1 0 1\n")})
                       .value();
  EXPECT_EQ(log.source, "a + b");
  EXPECT_THAT(log.poses, ElementsAre(PoseId{0, 0}, PoseId{0, 1}, PoseId{1, 0}, PoseId{1, 1}));
  EXPECT_THAT(log.features, ElementsAre(FeatureId{7}, FeatureId{8}));
  EXPECT_THAT(log.sessions, SizeIs(2));
  EXPECT_THAT(log.odometry(), SizeIs(2));
}

TEST(MergedLogs, OwnFeaturesAreNumberedApart) {
  const std::string text = edge(0, 1) + "EDGE_SE2_XY 1 7 1 0 1 0 1\nEDGE_SE2_XY 1 12 1 0 1 0 1\n";
  const auto log = merged<2>({log_of("a", text), log_of("b", text)}, {.own_features = true}).value();
  EXPECT_THAT(log.features, ElementsAre(FeatureId{7}, FeatureId{12}, FeatureId{107}, FeatureId{112}));
  const auto large = log_of("c", "EDGE_SE2_XY 1 18446744073709551615 1 0 1 0 1\n");
  EXPECT_THAT(merged<2>({large, large}, {.own_features = true}).error().message, HasSubstr("too large to number"));
}

TEST(MergedLogs, SessionsBeyond32BitsAreRefused) {
  auto late = log_of("late", edge(0, 1));
  for (PoseId& id : late.poses) id.session = 4294967295U;
  EXPECT_TRUE(merged<2>({log_of("early", edge(0, 1))}));
  EXPECT_THAT(merged<2>({late, late}).error().message, HasSubstr("late: with the sessions of the inputs before"));
}

TEST(MergedLogs, EdgesThatNamePosesOfAnotherLogTieThem) {
  const auto log =
      merged<2>({log_of("a", vertices(0, 2) + edge(0, 1) + edge(1, 101)), log_of("b", vertices(100, 2) + edge(100, 101))})
          .value();
  ASSERT_THAT(log.closures(), SizeIs(1));
  EXPECT_EQ(log.poses[log.closures()[0].base], (PoseId{0, 1}));
  EXPECT_EQ(log.poses[log.closures()[0].target], (PoseId{1, 101}));
  EXPECT_THAT(log.initial.poses, SizeIs(4));
}

TEST(MergedLogs, AnEdgeThatStandsInTwoLogsCountsOnceUnlessAllAreKept) {
  const auto a = log_of("a", vertices(0, 2) + edge(0, 1) + edge(1, 100) + edge(1, 100));
  const auto b = log_of("b", vertices(100, 2) + edge(100, 101) + edge(1, 100) + "EDGE_SE2 1 100 2 0 0 1 0 0 1 0 1\n");
  const auto c = log_of("c", vertices(200, 2) + edge(200, 201) + edge(100, 101) + edge(201, 0));
  const auto log = merged<2>({a, b, c}).value();
  EXPECT_THAT(log.closures(), SizeIs(4)) << "two of a, the one of b with other numbers, and that of c to a";
  EXPECT_EQ(log.skipped.at("copies of edges in another file"), 2);
  EXPECT_THAT(merged<2>({a, b, c}, {.keep_copies = true})->edges(), SizeIs(3 + 4 + 2));
}

TEST(MergedLogs, EveryEdgeOfALogMayStandInAnotherToo) {
  constexpr int kPoses = 100'000;
  std::string edges;
  for (std::uint64_t k = 0; k + 1 < 2 * kPoses; ++k) edges += edge(k, k + 1);
  const auto a = log_of("a", vertices(0, kPoses) + edges);
  const auto b = log_of("b", vertices(kPoses, kPoses) + edges);
  const EffortMeter meter;
  const auto log = merged<2>({a, b}).value();
  EXPECT_LT(meter.so_far().cpu_seconds, 20.0) << "a look at every edge for every edge takes a minute";
  EXPECT_THAT(log.edges(), SizeIs(2 * kPoses - 1));
  EXPECT_EQ(log.skipped.at("copies of edges in another file"), 2 * kPoses - 1);
}

TEST(MergedLogs, NameAnEdgeToAPoseThatNoLogOrSeveralDeclare) {
  const auto a = log_of("a", vertices(0, 2) + edge(0, 1) + edge(1, 100));
  const auto b = log_of("b", vertices(100, 2) + edge(100, 101));
  EXPECT_THAT(merged<2>({a, log_of("b", vertices(200, 2) + edge(200, 201))}).error().message,
              HasSubstr("a: the edge from pose 1 to pose 100 names pose 100, which no log declares; give the log that does, "
                        "too, or --skip-undeclared"));
  EXPECT_EQ(merged<2>({a, b, b}).error().message,
            "a: the edge from pose 1 to pose 100 names pose 100, which several other logs declare: b, b");
}

TEST(MergedLogs, TheFirstThatFixesPosesHoldsTheMap) {
  const auto fixed = log_of("a", vertices(0, 2) + edge(0, 1) + "FIX 1\n");
  const auto log = merged<2>({log_of("b", edge(5, 6)), fixed, fixed}).value();
  ASSERT_THAT(log.graph.fixed, SizeIs(1));
  EXPECT_EQ(log.poses[log.graph.fixed[0].pose], (PoseId{1, 1}));
  EXPECT_EQ(log.skipped.at("fixed poses of other files"), 1);
}

TEST(MergedLogs, TheFirstWithPriorsHoldsTheMapBeforeAnyThatFixesPoses) {
  const auto fixed = log_of("a", vertices(0, 2) + edge(0, 1) + "FIX 1\n");
  const std::string position = "EDGE_PRIOR_SE2_XY 1 4e5 5e6 1 0 1\n";
  const auto placed = log_of("b", vertices(0, 2) + edge(0, 1) + position);
  for (const auto& log : {merged<2>({fixed, placed}).value(), merged<2>({placed, fixed}).value()}) {
    EXPECT_THAT(log.graph.fixed, SizeIs(0)) << "in a frame of its own, and not that of the priors";
    EXPECT_THAT(log.pose_priors(), SizeIs(1));
    EXPECT_EQ(log.skipped.at("fixed poses of other files"), 1);
  }
  const auto both = log_of("c", vertices(0, 2) + edge(0, 1) + position + "FIX 0\n");
  const auto log = merged<2>({fixed, both}).value();
  ASSERT_THAT(log.graph.fixed, SizeIs(1));
  EXPECT_EQ(log.poses[log.graph.fixed[0].pose], (PoseId{1, 0}));
}

TEST(MergedLogs, KeepTimeStampsOnlyIfAllHaveThem) {
  auto stamped = log_of("a", edge(0, 1));
  stamped.stamps_ns = Table<PoseIndex, std::int64_t>(2, 7);
  EXPECT_THAT(merged<2>({stamped, stamped})->stamps_ns, SizeIs(4));
  const auto log = merged<2>({stamped, log_of("b", edge(0, 1))}).value();
  EXPECT_THAT(log.stamps_ns, SizeIs(0));
  EXPECT_EQ(log.skipped.at("time stamps that other files lack"), 2);
}

TEST(MergedLogs, HaveNoInitialValuesIfSeveralHaveOneOfAFeature) {
  const auto seen = [](const std::string& place) {
    return vertices(0, 2) + "VERTEX_XY 7 " + place + "\n" + edge(0, 1) + "EDGE_SE2_XY 1 7 1 0 1 0 1\n";
  };
  const auto log = merged<2>({log_of("a", seen("2 0")), log_of("b", seen("5 9") + "FIX 1\n"), log_of("c", edge(0, 1))}).value();
  EXPECT_THAT(log.features, ElementsAre(FeatureId{7}));
  EXPECT_THAT(log.initial.poses, SizeIs(0));
  EXPECT_THAT(log.initial.features, SizeIs(0));
  EXPECT_EQ(log.skipped.at("initial values, each in the frame of its file"), 6);
  EXPECT_THAT(log.graph.fixed, SizeIs(1)) << "whose value holds the map";
  const auto apart = merged<2>({log_of("a", seen("2 0")), log_of("b", seen("5 9"))}, {.own_features = true}).value();
  EXPECT_THAT(apart.initial.features, SizeIs(2));
}

TEST(MergedLogs, AreOfTheConventionsInsideIfTheyWereReadInDifferentOnes) {
  const auto ours = log_of("ours", edge(0, 1));
  auto theirs = log_of("theirs", edge(0, 1));
  theirs.conventions = {PoseError::kG2o, RotationInformation::kQuaternion, Covariance::kOriginal, {.missing = 2}};
  const auto conventions = [](const std::vector<Log<2>>& logs) { return merged<2>(logs)->conventions; };
  EXPECT_EQ(conventions({theirs, theirs}).pose_error, PoseError::kG2o);
  EXPECT_EQ(conventions({theirs, theirs}).rotation_information, RotationInformation::kQuaternion);
  for (const auto& mixed : {conventions({theirs, ours}), conventions({ours, theirs})}) {
    EXPECT_EQ(mixed.pose_error, PoseError::kPaper);
    EXPECT_EQ(mixed.rotation_information, RotationInformation::kVector);
    EXPECT_EQ(mixed.repairs.missing, 2);
  }
}

TEST(MergedLogs, OfDifferentWeightsAreRefused) {
  auto identity = log_of("i", edge(0, 1));
  use_identity_covariance(identity);
  EXPECT_EQ(merged<2>({identity, identity})->conventions.covariance, Covariance::kIdentity);
  EXPECT_EQ(merged<2>({identity, log_of("a", edge(0, 1))}).error().message,
            "i has weights of --covariance identity and a of --covariance original: build both with the same");
  auto inflated = log_of("i", edge(0, 1));
  inflate({.odometry = 2.0}, inflated);
  for (const auto& both : {std::vector{inflated, log_of("a", edge(0, 1))}, std::vector{log_of("a", edge(0, 1)), inflated}}) {
    EXPECT_THAT(merged<2>(both).error().message,
                ::testing::HasSubstr("weights of different --inflate: build both with the same"));
  }
}

TEST(MergedLogs, AreNoCopiesIfAnyNumberDiffers) {
  const auto message = [](const auto& parts) { return testing::error_of(check_no_copies(parts)); };
  const std::string text = edge(0, 1) + edge(0, 1) + "EDGE_SE2_XY 0 7 2 0 1 0 1\n";
  const auto a = log_of("a", text);
  auto copy = log_of("copy", text);
  copy.initial.poses.resize(2);
  EXPECT_EQ(message(std::vector{a, log_of("b", edge(0, 1)), copy}),
            "copy has the same poses, features and measurements as a, number by number, which would count twice: leave one "
            "out; --keep-copies takes both for robots");
  auto other = a;
  other.graph.feature_factors[0].measured[0] += 1e-15;
  EXPECT_EQ(message(std::vector{a, other}), "");
  const auto robot = log_of("robot", edge(0, 1));
  EXPECT_EQ(message(std::vector{robot, robot}), "") << "of steps alone, which may be alike";
}

TEST(MergedLogs, CountNoCopyTwiceUnlessAllAreKept) {
  const auto a = log_of("a", edge(0, 1) + edge(0, 1));
  EXPECT_THAT(testing::error_of(merged<2>({a, a})), ::testing::HasSubstr("number by number, which would count twice"));
  EXPECT_THAT(merged<2>({a, a}, {.keep_copies = true})->edges(), SizeIs(4));
}

TEST(MergedLogs, MustBeSoundAndThere) {
  const auto a = log_of("a", edge(0, 1));
  auto broken = a;
  broken.graph.pose_factors[0].target = 77;
  EXPECT_EQ(testing::error_of(merged<2>({a, broken})),
            "a: pose factor 0, from pose 0 to index 77, names a pose or feature that is not there");
  EXPECT_THROW((void)merged<2>({}), std::invalid_argument);
}

TEST(MergedLogs, SetsOfMapsAreCopiesToo) {
  const auto message = [](const auto& parts) { return testing::error_of(check_no_copies(parts)); };
  SubmapSet<2> set;
  set.source = "maps";
  set.poses = {{0, 0}, {0, 1}, {0, 2}};
  set.features = {{7}};
  const Eigen::MatrixXd W = Eigen::MatrixXd::Identity(5, 5);
  for (const PoseIndex base : {PoseIndex(0), PoseIndex(1)}) {
    set.graph.submaps.push_back({base, {base + 1}, {0}, {Pose<2>{}}, {Point<2>(1.0, 2.0)}, W});
  }
  SubmapSet<2> other = set;
  EXPECT_THAT(message(std::vector{set, other}), HasSubstr("maps has the same poses, features and measurements as maps"));
  other.graph.submaps[1].information(0, 0) = 2.0;
  EXPECT_EQ(message(std::vector{set, other}), "");
}

TEST(MergedLogs, CountWhatEachLeftOut) {
  const std::string text = edge(0, 1) + "ROBOTLASER1 0\n";
  EXPECT_EQ(merged<2>({log_of("a", text), log_of("b", text)})->skipped.at("ROBOTLASER1 lines"), 2);
}

}  // namespace
}  // namespace mapjoin
