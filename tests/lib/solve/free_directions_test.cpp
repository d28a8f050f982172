// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/solve/free_directions.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

/// Three poses and two features, and null vectors that move or turn some of them.
template <typename Dimension>
class FreeDirectionsTest : public ::testing::Test {
 protected:
  static constexpr int kDim = Dimension::value;

  FreeDirectionsTest() {
    for (int p = 0; p < 3; ++p) add("pose " + std::to_string(p), true);
    for (int f = 7; f < 9; ++f) add("feature " + std::to_string(f), false);
  }

  void add(const std::string& name, bool is_pose) {
    Pose<kDim> value;
    value.translation = random_.vector<kDim>();
    if (is_pose) value.rotation = Rotation<kDim>::exp(random_.vector<kRotationDof<kDim>>());
    variables_.push_back({name, value, size_, is_pose});
    size_ += is_pose ? kPoseDof<kDim> : kDim;
  }

  /// Null vectors that turn some variables about a point: one for each axis.
  Eigen::MatrixXd turned(const std::vector<std::size_t>& which, const Point<kDim>& centre) const {
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(size_, kRotationDof<kDim>);
    for (const std::size_t v : which) {
      const auto& variable = variables_[v];
      const Point<kDim> arm = variable.value.translation - centre;
      if constexpr (kDim == 2) N.template block<2, 1>(variable.offset, 0) << -arm.y(), arm.x();
      if constexpr (kDim == 3) N.template block<3, 3>(variable.offset, 0) = -skew(arm);
      if (!variable.is_pose) continue;
      if constexpr (kDim == 2) N(variable.offset + 2, 0) = 1.0;
      if constexpr (kDim == 3) N.template block<3, 3>(variable.offset + 3, 0) = variable.value.rotation.matrix().transpose();
    }
    return N;
  }
  Eigen::MatrixXd moved(const std::vector<std::size_t>& which) const {
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(size_, kDim);
    for (const std::size_t v : which) N.middleRows(variables_[v].offset, kDim).setIdentity();
    return N;
  }
  static Eigen::MatrixXd both(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
    Eigen::MatrixXd N(A.rows(), A.cols() + B.cols());
    N << A, B;
    return N;
  }
  std::string said(const Eigen::MatrixXd& N) const { return free_directions(variables_, N); }

  testing::Random random_;
  std::vector<PlacedVariable<kDim>> variables_;
  Eigen::Index size_ = 0;
};
TYPED_TEST_SUITE(FreeDirectionsTest, testing::Dimensions);

TYPED_TEST(FreeDirectionsTest, NameASingleVariable) {
  EXPECT_EQ(this->said(this->moved({3})), "feature 7 cannot be determined: the observations leave it free to move");
  EXPECT_EQ(this->said(this->moved({3}).leftCols(1)), "feature 7 cannot be determined: the observations leave it free to move");
  const auto pose = this->variables_[1].value.translation;
  EXPECT_EQ(this->said(this->turned({1}, pose)), "pose 1 cannot be determined: the observations leave it free to turn");
  EXPECT_EQ(this->said(this->both(this->turned({1}, pose), this->moved({1}))),
            "pose 1 cannot be determined: the observations leave it free to move");
}

TYPED_TEST(FreeDirectionsTest, NameWhatMovesOrTurnsAsAWhole) {
  const auto about = this->variables_[4].value.translation;
  const std::string start = "pose 1, pose 2 and feature 7 cannot be determined: the observations leave them free to ";
  EXPECT_EQ(this->said(this->moved({1, 2, 3})), start + "move as a whole");
  EXPECT_EQ(this->said(this->turned({1, 2, 3}, about)), start + "turn as a whole about feature 8");
  EXPECT_EQ(this->said(this->both(this->turned({1, 2, 3}, about), this->moved({1, 2, 3}))), start + "move and turn as a whole");
}

TYPED_TEST(FreeDirectionsTest, NameWhatIsNoRigidMotion) {
  Eigen::MatrixXd N = this->moved({1, 2}).leftCols(1);
  N(this->variables_[2].offset, 0) = -1.0;
  EXPECT_EQ(this->said(N),
            "pose 1 and pose 2 cannot be determined: the observations leave them free to move against each other");
}

TYPED_TEST(FreeDirectionsTest, NameIndependentPartsOneByOne) {
  EXPECT_EQ(this->said(this->both(this->moved({3}), this->moved({4}))),
            "feature 7 cannot be determined: the observations leave it free to move; "
            "feature 8 cannot be determined: the observations leave it free to move");
  EXPECT_EQ(this->said(Eigen::MatrixXd(this->size_, 0)), "");
}

TYPED_TEST(FreeDirectionsTest, NameThreePartsAtMost) {
  const Eigen::MatrixXd three = this->both(this->both(this->moved({1}), this->moved({2})), this->moved({3}));
  EXPECT_EQ(this->said(this->both(three, this->moved({4}))), this->said(three));
}

TYPED_TEST(FreeDirectionsTest, TakeRoundingForNoMotion) {
  const auto about = this->variables_[4].value.translation;
  for (const Eigen::MatrixXd& N : {this->moved({3}), this->turned({1, 2, 3}, about)}) {
    const Eigen::MatrixXd rounding = Eigen::MatrixXd::Constant(N.rows(), N.cols(), 1e-9);
    EXPECT_EQ(this->said(N + rounding), this->said(N));
  }
}

TYPED_TEST(FreeDirectionsTest, SayTheSameInAnyUnitOfLength) {
  const auto about = this->variables_[4].value.translation;
  for (const Eigen::MatrixXd& N : {this->moved({1, 2, 3}), this->turned({1, 2, 3}, about), this->turned({0, 1}, about)}) {
    for (const double unit : {1e-7, 1e-3, 1e3, 1e7}) {
      auto variables = this->variables_;
      Eigen::MatrixXd in_unit = N;
      for (auto& variable : variables) {
        variable.value.translation *= unit;
        in_unit.middleRows<TestFixture::kDim>(variable.offset) *= unit;
      }
      EXPECT_EQ(free_directions(variables, in_unit), this->said(N)) << unit;
    }
  }
}

TYPED_TEST(FreeDirectionsTest, NameWhatMovesAThousandTimesLess) {
  Eigen::MatrixXd N = this->moved({3}).leftCols(1);
  N(this->variables_[4].offset, 0) = 1e-3;
  EXPECT_EQ(this->said(N).substr(0, 41), "feature 7 and feature 8 cannot be determi");
}

TYPED_TEST(FreeDirectionsTest, NameAFewOfMany) {
  for (int p = 20; p < 30; ++p) this->add("pose " + std::to_string(p), true);
  std::vector<std::size_t> all;
  for (std::size_t v = 0; v < this->variables_.size(); ++v) all.push_back(v);
  EXPECT_EQ(this->said(this->moved(all)).substr(0, 35), "pose 0, pose 1, pose 2 and 12 other");
}

}  // namespace
}  // namespace mapjoin
