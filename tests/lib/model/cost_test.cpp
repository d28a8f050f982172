// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/model/accumulate.hpp>
#include <mapjoin/model/cost.hpp>
#include <numbers>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

TEST(CostTest, WeighsTheHeadingDifferenceTheShortWayRound) {
  PoseFactor<2> observation;
  observation.measured.rotation = Rotation<2>(3.1);
  observation.information = Vector<3>(1.0, 1.0, 100.0).asDiagonal();
  const Pose<2> target{{0.0, 0.0}, Rotation<2>(-3.1)};
  const double difference = 2.0 * std::numbers::pi - 6.2;
  EXPECT_NEAR(cost(observation, Pose<2>{}, target), 100.0 * difference * difference, 1e-12);
}

/// A sink that takes -½ of the gradient with respect to the target alone.
template <int Dof>
struct TargetGradient {
  template <typename Block>
  void hessian(int, int, const Block&) {}
  template <typename Block>
  void rhs(int slot, const Block& block) {
    if constexpr (Block::RowsAtCompileTime == Dof) {
      if (slot == 1) g = block;
    }
  }
  Vector<Dof> g = Vector<Dof>::Zero();
};

template <typename D>
class CostOfDimensionTest : public ::testing::Test {};
TYPED_TEST_SUITE(CostOfDimensionTest, testing::Dimensions);

TYPED_TEST(CostOfDimensionTest, GaussNewtonHasTheCostAndHalfItsGradientByEveryLoss) {
  constexpr int kDim = TypeParam::value;
  testing::Random random;
  const std::vector<std::pair<const char*, Loss>> losses = {{"quadratic", {}},
                                                            {"inside", Loss::truncated(1e6, 0.5)},
                                                            {"arc", Loss::truncated(5.0, 1e-3)},
                                                            {"constant", Loss::truncated(1e-6, 0.5)}};
  for (const auto& [name, loss] : losses) {
    FeatureFactor<kDim> observation{0, 0, random.vector<kDim>(), random.information<kDim>(), loss};
    const Pose<kDim> base = random.pose<kDim>();
    const Point<kDim> feature = random.vector<kDim>();
    TargetGradient<kDim> sink;
    EXPECT_NEAR(accumulate(linearise(observation, base, feature), sink), cost(observation, base, feature), 1e-12) << name;
    const double h = 1e-6;
    for (int i = 0; i < kDim; ++i) {
      const Point<kDim> step = h * Point<kDim>::Unit(i);
      const double more = cost(observation, base, Point<kDim>(feature + step));
      const double less = cost(observation, base, Point<kDim>(feature - step));
      EXPECT_NEAR((more - less) / (2.0 * h), -2.0 * sink.g[i], 1e-6 * (1.0 + sink.g.norm())) << name;
    }
  }
}

}  // namespace
}  // namespace mapjoin
