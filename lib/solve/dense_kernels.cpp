// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/solve/blas.hpp>
#include <mapjoin/solve/dense_kernels.hpp>
#include <mutex>

namespace mapjoin {
namespace {

constexpr double kOne = 1.0;
constexpr double kMinusOne = -1.0;

/// A call of the BLAS on the calling thread alone. Its own number of threads holds for the process, OpenMP's for each thread.
class OneThread {
 public:
  OneThread() : openmp_threads_(blas().get_openmp_threads ? blas().get_openmp_threads() : 0), alone_(mutex_, std::defer_lock) {
    if (openmp_threads_ > 1) blas().set_openmp_threads(1);
    if (blas().must_be_alone) alone_.lock();
  }
  ~OneThread() {
    if (openmp_threads_ > 1) blas().set_openmp_threads(openmp_threads_);
  }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  static inline std::mutex mutex_;
  int openmp_threads_;  ///< Before the call.
  std::unique_lock<std::mutex> alone_;
};

int stride(const auto& block) {
  return static_cast<int>(block.outerStride());
}

double beta_of(Into into) {
  return into == Into::kSum ? 1.0 : 0.0;
}

}  // namespace

std::optional<Eigen::Index> cholesky_in_place(DenseBlock A) {
  const OneThread one_thread;
  const auto n = static_cast<int>(A.rows());
  const int lda = stride(A);
  int info = 0;
  blas().potrf("L", &n, A.data(), &lda, &info);
  return info > 0 ? std::optional<Eigen::Index>(info - 1) : std::nullopt;
}

void divide_by_transpose(ConstDenseBlock L, DenseBlock B) {
  const OneThread one_thread;
  const auto m = static_cast<int>(B.rows());
  const auto n = static_cast<int>(B.cols());
  const int lda = stride(L);
  const int ldb = stride(B);
  blas().trsm("R", "L", "T", "N", &m, &n, &kOne, L.data(), &lda, B.data(), &ldb);
}

void subtract_square(ConstDenseBlock B, DenseBlock C, Into into) {
  const OneThread one_thread;
  const double beta = beta_of(into);
  const auto n = static_cast<int>(B.rows());
  const auto k = static_cast<int>(B.cols());
  const int lda = stride(B);
  const int ldc = stride(C);
  blas().syrk("L", "N", &n, &k, &kMinusOne, B.data(), &lda, &beta, C.data(), &ldc);
}

void subtract_product(ConstDenseBlock A, ConstDenseBlock B, DenseBlock C, Into into) {
  const OneThread one_thread;
  const double beta = beta_of(into);
  const auto m = static_cast<int>(A.rows());
  const auto n = static_cast<int>(B.rows());
  const auto k = static_cast<int>(A.cols());
  const int lda = stride(A);
  const int ldb = stride(B);
  const int ldc = stride(C);
  blas().gemm("N", "T", &m, &n, &k, &kMinusOne, A.data(), &lda, B.data(), &ldb, &beta, C.data(), &ldc);
}

}  // namespace mapjoin
