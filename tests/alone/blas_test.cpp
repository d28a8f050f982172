// SPDX-License-Identifier: BSD-3-Clause
// In a program of their own: the reference solver of the other tests brings a BLAS along. And each in a process of its own, as
// ctest runs them: a BLAS is loaded once.

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <mapjoin/solve/blas.hpp>
#include <mapjoin/solve/dense_kernels.hpp>
#include <tests/support/threads.hpp>

namespace mapjoin {
namespace {

/// Of a matrix large enough for a BLAS to use all its threads.
Eigen::VectorXd diagonal_of_factor() {
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(400, 400) * 4.0;
  EXPECT_FALSE(cholesky_in_place(DenseBlock(A.data(), 400, 400, Eigen::OuterStride<>(400))));
  return A.diagonal();
}

TEST(Blas, IsLoadedWhenItIsFirstAskedFor) {
  ASSERT_EQ(dlopen("libopenblas.so.0", RTLD_LAZY | RTLD_NOLOAD), nullptr);
  EXPECT_FALSE(blas().name.empty());
  EXPECT_NE(dlopen("libopenblas.so.0", RTLD_LAZY | RTLD_NOLOAD), nullptr);
  EXPECT_EQ(diagonal_of_factor(), Eigen::VectorXd::Constant(400, 2.0));
}

TEST(Blas, LeavesNoThreads) {
  const std::ptrdiff_t before = testing::threads_of_this_process();
  EXPECT_EQ(diagonal_of_factor(), Eigen::VectorXd::Constant(400, 2.0));
  EXPECT_EQ(testing::threads_of_this_process(), before);
}

TEST(Blas, IsTheOneThatTheProgramHasLoadedAlready) {
  void* const lapack = dlopen("liblapack.so.3", RTLD_NOW | RTLD_GLOBAL);
  ASSERT_NE(lapack, nullptr) << dlerror();
  EXPECT_EQ(reinterpret_cast<void*>(blas().potrf), dlsym(lapack, "dpotrf_"));
  EXPECT_EQ(diagonal_of_factor(), Eigen::VectorXd::Constant(400, 2.0));
}

}  // namespace
}  // namespace mapjoin
