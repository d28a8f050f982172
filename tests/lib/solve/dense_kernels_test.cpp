// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <mapjoin/solve/dense_kernels.hpp>

namespace mapjoin {
namespace {

TEST(DenseKernels, WriteANewProductWithoutReadingWhatWasThere) {
  const Eigen::MatrixXd B = Eigen::MatrixXd::Constant(60, 7, 0.5);
  const ConstDenseBlock block(B.data(), 60, 7, Eigen::OuterStride<>(60));
  Eigen::MatrixXd C = Eigen::MatrixXd::Constant(60, 60, std::numeric_limits<double>::quiet_NaN());
  const DenseBlock result(C.data(), 60, 60, Eigen::OuterStride<>(60));
  subtract_square(block, result, Into::kNew);
  EXPECT_TRUE(Eigen::MatrixXd(C.triangularView<Eigen::Lower>())
                  .isApprox(Eigen::MatrixXd(Eigen::MatrixXd::Constant(60, 60, -1.75).triangularView<Eigen::Lower>())));
  C.fill(std::numeric_limits<double>::quiet_NaN());
  subtract_product(block, block, result, Into::kNew);
  EXPECT_TRUE(C.isApprox(Eigen::MatrixXd::Constant(60, 60, -1.75)));
}

}  // namespace
}  // namespace mapjoin
