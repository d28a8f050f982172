// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/model/accumulate.hpp>
#include <mapjoin/model/cost.hpp>
#include <numeric>
#include <tests/support/dimensions.hpp>
#include <tests/support/numerical_jacobian.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using testing::Random;

/// A sink that collects blocks into a dense system whose slots have the given widths.
class DenseSink {
 public:
  explicit DenseSink(std::vector<Eigen::Index> widths) : begin_(widths.size() + 1, 0) {
    std::partial_sum(widths.begin(), widths.end(), begin_.begin() + 1);
    H = Eigen::MatrixXd::Zero(begin_.back(), begin_.back());
    g = Eigen::VectorXd::Zero(begin_.back());
  }
  template <typename Block>
  void hessian(int i, int j, const Block& block) {
    ASSERT_LE(i, j);
    const Eigen::MatrixXd value = block;
    H.block(at(i), at(j), value.rows(), value.cols()) += value;
    if (i < j) H.block(at(j), at(i), value.cols(), value.rows()) += value.transpose();
  }
  template <typename Block>
  void rhs(int i, const Block& block) {
    const Eigen::VectorXd value = block;
    g.segment(at(i), value.size()) += value;
  }

  Eigen::MatrixXd H;
  Eigen::VectorXd g;

 private:
  Eigen::Index at(int slot) const { return begin_[static_cast<std::size_t>(slot)]; }
  std::vector<Eigen::Index> begin_;
};

/// Expects JᵀWJ, JᵀWr and rᵀWr in the sink and in chi2.
void expect_dense(const DenseSink& sink, double chi2, const Eigen::MatrixXd& J, const Eigen::MatrixXd& W,
                  const Eigen::VectorXd& r) {
  const Eigen::MatrixXd H = J.transpose() * W * J;
  EXPECT_LT((sink.H - H).norm(), 1e-11 * (1.0 + H.norm()));
  const Eigen::VectorXd g = J.transpose() * (W * r);
  EXPECT_LT((sink.g - g).norm(), 1e-11 * (1.0 + g.norm()));
  EXPECT_NEAR(chi2, r.dot(W * r), 1e-11 * (1.0 + chi2));
}

template <typename D>
class AccumulateTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr int kDof = kPoseDof<kDim>;

  template <int Dof>
  LinearTarget<kDim, Dof> random_target() {
    LinearTarget<kDim, Dof> target;
    target.residual = random.vector<Dof>();
    for (auto& entry : target.J_target.reshaped()) entry = random.uniform(-1.0, 1.0);
    for (auto& entry : target.J_base.reshaped()) entry = random.uniform(-1.0, 1.0);
    return target;
  }
  template <int Dof>
  void expect_single(const LinearTarget<kDim, Dof>& target, const Matrix<Dof>& W) {
    DenseSink sink({kDof, Dof});
    const double chi2 = accumulate(weighted(target, W, Loss{}), sink);
    Eigen::MatrixXd J(Dof, kDof + Dof);
    J << target.J_base, target.J_target;
    expect_dense(sink, chi2, J, W, target.residual);
  }

  Random random;
};
TYPED_TEST_SUITE(AccumulateTest, testing::Dimensions);

TYPED_TEST(AccumulateTest, APoseFactorGivesItsDenseNormalEquations) {
  constexpr int kDof = TestFixture::kDof;
  for (int k = 0; k < 5; ++k) {
    this->template expect_single<kDof>(this->template random_target<kDof>(), this->random.template information<kDof>());
  }
}

TYPED_TEST(AccumulateTest, AFeatureFactorGivesItsDenseNormalEquations) {
  constexpr int kDim = TestFixture::kDim;
  for (int k = 0; k < 5; ++k) {
    this->template expect_single<kDim>(this->template random_target<kDim>(), this->random.template information<kDim>());
  }
}

TYPED_TEST(AccumulateTest, RowsThatWereNotMeasuredCountForNothing) {
  constexpr int kDof = TestFixture::kDof;
  constexpr int kRot = kRotationDof<TestFixture::kDim>;
  Matrix<kDof> W = this->random.template information<kDof>();
  W.template rightCols<kRot>().setZero();
  W.template bottomRows<kRot>().setZero();
  auto target = this->template random_target<kDof>();
  this->template expect_single<kDof>(target, W);
  DenseSink before({kDof, kDof});
  accumulate(weighted(target, W, Loss{}), before);
  target.residual.template tail<kRot>().array() += 17.0;
  DenseSink after({kDof, kDof});
  accumulate(weighted(target, W, Loss{}), after);
  EXPECT_EQ((before.g - after.g).norm(), 0.0);
}

TYPED_TEST(AccumulateTest, ALocalMapGivesItsDenseNormalEquations) {
  constexpr int kDim = TestFixture::kDim;
  constexpr int kDof = TestFixture::kDof;
  for (const auto& [poses, features] : {std::pair{1, 0}, {0, 2}, {1, 3}, {2, 4}}) {
    const Eigen::Index rows = poses * kDof + features * kDim;
    LinearMap<kDim> linear;
    std::vector<Eigen::Index> widths{kDof};
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, kDof + rows);
    Eigen::VectorXd r(rows);
    Eigen::Index row = 0;
    const auto add = [&](const auto& target) {
      const Eigen::Index dof = target.residual.size();
      J.block(row, 0, dof, kDof) = target.J_base;
      J.block(row, kDof + row, dof, dof) = target.J_target;
      r.segment(row, dof) = target.residual;
      widths.push_back(dof);
      row += dof;
    };
    for (int k = 0; k < poses; ++k) add(linear.poses.emplace_back(this->template random_target<kDof>()));
    for (int k = 0; k < features; ++k) add(linear.features.emplace_back(this->template random_target<kDim>()));
    Eigen::MatrixXd A(rows, rows - 1);  // W gets a null space, as that of a map of bearings has
    for (auto& entry : A.reshaped()) entry = this->random.uniform(-1.0, 1.0);
    LocalMap<kDim> map;
    map.poses.resize(static_cast<std::size_t>(poses));
    map.features.resize(static_cast<std::size_t>(features));
    map.information = A * A.transpose();
    linear.map = &map;
    DenseSink sink(widths);
    const double chi2 = accumulate(linear, sink);
    expect_dense(sink, chi2, J, map.information, r);
  }
}

/// The matrix ½ ∂²f/∂δ² at δ = 0, by central differences.
template <typename F>
Eigen::MatrixXd half_of_second_derivatives(F&& f, Eigen::Index size) {
  constexpr double kStep = 1e-4;
  const auto gradient = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
    const auto value = [&](const Eigen::VectorXd& step) { return Eigen::VectorXd::Constant(1, f(at + step)).eval(); };
    return testing::numerical_jacobian(value, size, kStep).transpose();
  };
  return 0.5 * testing::numerical_jacobian(gradient, size, kStep);
}

TYPED_TEST(AccumulateTest, CurvatureMakesTheHessianThatOfFullNewton) {
  constexpr int kDim = TestFixture::kDim;
  constexpr int kDof = TestFixture::kDof;
  for (int k = 0; k < 5; ++k) {
    LocalMap<kDim> map;
    map.poses = {1};
    map.features = {0};
    map.pose_estimates = {this->random.template pose<kDim>()};
    map.feature_estimates = {this->random.template vector<kDim>()};
    map.information = this->random.template information<kDof + kDim>();
    const Pose<kDim> base = this->random.template pose<kDim>();
    const Pose<kDim> end = this->random.template pose<kDim>();
    const Point<kDim> feature = this->random.template vector<kDim>();
    const auto chi2 = [&](const Eigen::VectorXd& step) {
      const Pose<kDim> moved_end = retract<kDim>(end, step.segment<kDof>(kDof));
      const Point<kDim> moved_feature = feature + step.tail<kDim>();
      return cost(
          map, retract<kDim>(base, step.head<kDof>()), [&](std::size_t) { return moved_end; },
          [&](std::size_t) { return moved_feature; });
    };
    DenseSink sink({kDof, kDof, kDim});
    const auto linear = linearise(
        map, base, [&](std::size_t) { return end; }, [&](std::size_t) { return feature; });
    accumulate(linear, sink);
    const Eigen::MatrixXd gauss_newton = sink.H;
    accumulate_curvature(linear, sink);
    const Eigen::MatrixXd H = half_of_second_derivatives(chi2, 2 * kDof + kDim);
    EXPECT_LT((sink.H - H).norm(), 1e-5 * H.norm());
    EXPECT_GT((gauss_newton - H).norm(), 1e-2 * H.norm());
  }
}

TYPED_TEST(AccumulateTest, APriorIsAnObservationFromTheOrigin) {
  constexpr int kDim = TestFixture::kDim;
  const Pose<kDim> measured = this->random.template pose<kDim>();
  const Pose<kDim> target = this->random.template pose<kDim>();
  const Values<kDim> state{{target}, {}};
  const auto prior = linearise<kDim>(measured, state.pose(kWorld), state.pose(0));
  EXPECT_LT((prior.residual.template head<kDim>() - (measured.translation - target.translation)).norm(), 1e-14);
  EXPECT_LT((prior.J_target.template topLeftCorner<kDim, kDim>() - Matrix<kDim>::Identity()).norm(), 1e-14);
}

}  // namespace
}  // namespace mapjoin
