// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <numbers>
#include <tests/support/dimensions.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// A drive of two kilometres straight on, then to the left, where something is measured to a millimetre: the covariances of the
/// poses there are ten thousand million times as large, and rounding hides how little the drive says of it.
template <typename D>
class FarFromGaugeTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr std::uint64_t kSteps = 204;
  static constexpr PoseId kFirst{0, kSteps - 4}, kSecond{0, kSteps};  // 40 m apart

  FarFromGaugeTest() {
    Pose<kDim> step;
    step.translation[0] = 10.0;
    const PoseMatrix<kDim> W = diagonal(100.0, 4e4);
    const Pose<kDim> to_the_left =
        retract(step, PoseVector<kDim>(0.5 * std::numbers::pi * PoseVector<kDim>::Unit(kPoseDof<kDim> - 1)));
    for (std::uint64_t k = 0; k < kSteps; ++k) {
      drive_.add_pose_edge({0, k}, {0, k + 1}, k + 1 == kFirst.key ? to_the_left : step, W);
    }
  }
  /// A closure between the two poses whose position is wrong by so many metres in each direction.
  void close(double error) {
    Pose<kDim> measured;
    measured.translation.setConstant(error);
    measured.translation[0] += 40.0;
    drive_.add_pose_edge(kFirst, kSecond, measured, diagonal(4e5, 1e6));
  }
  /// A feature that the two poses see at places that differ by so many metres in each direction.
  void see(double difference) {
    Point<kDim> from_first = Point<kDim>::Constant(5.0);
    Point<kDim> from_second = Point<kDim>::Constant(5.0 + difference);
    from_first[0] += 20.0;
    from_second[0] -= 20.0;
    drive_.add_observation(kFirst, {1}, from_first, 4e5 * PointMatrix<kDim>::Identity());
    drive_.add_observation(kSecond, {1}, from_second, 4e5 * PointMatrix<kDim>::Identity());
  }
  Log<kDim> log() { return std::move(drive_).finish().value(); }

 private:
  static PoseMatrix<kDim> diagonal(double of_position, double of_rotation) {
    PoseVector<kDim> W = PoseVector<kDim>::Constant(of_rotation);
    W.template head<kDim>().setConstant(of_position);
    return W.asDiagonal();
  }

  LogBuilder<kDim> drive_{"drive"};
};
TYPED_TEST_SUITE(FarFromGaugeTest, testing::Dimensions);

/// Nothing is redundant without what closes the loop, so that the whole of chi2 is that of each of its parts.
template <int Dim>
void expect_whole_chi2(const RunResult<Dim>& result, PartKind kind, int rows) {
  const auto of_kind = std::ranges::find(result.fit.kinds, kind, &KindScale::kind);
  ASSERT_NE(of_kind, result.fit.kinds.end());
  EXPECT_NEAR(of_kind->scale * chi_squared_quantile(0.5, rows), result.chi2, 0.01 * result.chi2);
}

TYPED_TEST(FarFromGaugeTest, ASharpClosureIsTestedAsItIs) {
  this->close(0.1);
  const auto result = run(this->log(), {}).value();
  EXPECT_EQ(result.fit.verdict, Verdict::kFits);
  expect_whole_chi2(result, PartKind::kClosure, kPoseDof<TypeParam::value>);
}

TYPED_TEST(FarFromGaugeTest, SharpObservationsAreTestedAsTheyAre) {
  this->see(0.1);
  const auto result = run(this->log(), {}).value();
  EXPECT_EQ(result.fit.verdict, Verdict::kFits);
  expect_whole_chi2(result, PartKind::kObservation, TypeParam::value);
}

TYPED_TEST(FarFromGaugeTest, ASharpClosureThatIsWrongIsNamed) {
  this->close(5.0);
  const GoodnessOfFit fit = run(this->log(), {}).value().fit;
  ASSERT_FALSE(fit.misfits.empty());
  EXPECT_EQ(fit.misfits.front().kind, PartKind::kClosure);
}

}  // namespace
}  // namespace mapjoin
