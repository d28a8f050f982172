// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <mapjoin/solve/dense_kernels.hpp>
#include <tests/support/threads.hpp>

namespace mapjoin {
namespace {

using testing::threads_of_this_process;

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

/// In a process of its own, as ctest runs it: the number of threads is looked at once.
TEST(DenseKernels, StartNoThreadsAgainWhereTheseHaveBeenEnded) {
  end_blas_threads();
  const std::ptrdiff_t before = threads_of_this_process();
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(400, 400) * 4.0;
  const DenseBlock block(A.data(), 400, 400, Eigen::OuterStride<>(400));
  ASSERT_FALSE(cholesky_in_place(block));
  EXPECT_EQ(A.diagonal(), Eigen::VectorXd::Constant(400, 2.0));
  EXPECT_EQ(threads_of_this_process(), before);
}

}  // namespace
}  // namespace mapjoin
