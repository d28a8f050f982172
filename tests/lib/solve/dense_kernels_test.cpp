// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <mapjoin/solve/dense_kernels.hpp>

namespace mapjoin {
namespace {

std::ptrdiff_t threads_of_this_process() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
}

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
