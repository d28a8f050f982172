// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <mapjoin/solve/engines/frontal_matrix.hpp>

extern "C" {  // Null if the BLAS is not OpenBLAS.
[[gnu::weak]] int openblas_get_num_threads();
[[gnu::weak]] void openblas_set_num_threads(int);
}

namespace mapjoin {
namespace {

TEST(FrontalMatrix, WriteANewProductWithoutReadingWhatWasThere) {
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

TEST(FrontalMatrix, LeaveTheNumberOfBlasThreadsToTheProgram) {
  if (!openblas_get_num_threads || !openblas_set_num_threads) GTEST_SKIP() << "another BLAS";
  const int before = openblas_get_num_threads();
  openblas_set_num_threads(2);
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(400, 400) * 4.0;
  EXPECT_FALSE(cholesky_in_place(DenseBlock(A.data(), 400, 400, Eigen::OuterStride<>(400))));
  EXPECT_EQ(A.diagonal(), Eigen::VectorXd::Constant(400, 2.0));
  EXPECT_EQ(openblas_get_num_threads(), 2);
  openblas_set_num_threads(before);
}

}  // namespace
}  // namespace mapjoin
