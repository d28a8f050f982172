// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/solve/dense_kernels.hpp>
#include <mutex>

extern "C" {
// By the Fortran interface, which every BLAS and LAPACK has: all arguments are addresses.
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m, const int* n,
            const double* alpha, const double* a, const int* lda, double* b, const int* ldb);
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha, const double* a,
            const int* lda, const double* beta, double* c, const int* ldc);
void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c, const int* ldc);
// Null where the BLAS is not OpenBLAS, or where nothing in the process uses OpenMP.
[[gnu::weak]] int openblas_get_parallel();
[[gnu::weak]] int omp_get_max_threads();
[[gnu::weak]] void omp_set_num_threads(int);
}

namespace mapjoin {
namespace {

constexpr double kOne = 1.0;
constexpr double kMinusOne = -1.0;

/// The duration of a BLAS call. A BLAS on OpenMP works on the calling thread alone: OpenMP's number of threads belongs to the
/// thread that sets it. OpenBLAS built without threads is called by one thread at a time.
class BlasCall {
 public:
  BlasCall() : openmp_threads_(omp_get_max_threads ? omp_get_max_threads() : 1), alone_(mutex_, std::defer_lock) {
    if (openmp_threads_ > 1) omp_set_num_threads(1);
    if (openblas_get_parallel && openblas_get_parallel() == 0) alone_.lock();
  }
  ~BlasCall() {
    if (openmp_threads_ > 1) omp_set_num_threads(openmp_threads_);
  }
  BlasCall(const BlasCall&) = delete;
  BlasCall& operator=(const BlasCall&) = delete;

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
  const BlasCall call;
  const auto n = static_cast<int>(A.rows());
  const int lda = stride(A);
  int info = 0;
  dpotrf_("L", &n, A.data(), &lda, &info);
  return info > 0 ? std::optional<Eigen::Index>(info - 1) : std::nullopt;
}

void divide_by_transpose(ConstDenseBlock L, DenseBlock B) {
  const BlasCall call;
  const auto m = static_cast<int>(B.rows());
  const auto n = static_cast<int>(B.cols());
  const int lda = stride(L);
  const int ldb = stride(B);
  dtrsm_("R", "L", "T", "N", &m, &n, &kOne, L.data(), &lda, B.data(), &ldb);
}

void subtract_square(ConstDenseBlock B, DenseBlock C, Into into) {
  const BlasCall call;
  const double beta = beta_of(into);
  const auto n = static_cast<int>(B.rows());
  const auto k = static_cast<int>(B.cols());
  const int lda = stride(B);
  const int ldc = stride(C);
  dsyrk_("L", "N", &n, &k, &kMinusOne, B.data(), &lda, &beta, C.data(), &ldc);
}

void subtract_product(ConstDenseBlock A, ConstDenseBlock B, DenseBlock C, Into into) {
  const BlasCall call;
  const double beta = beta_of(into);
  const auto m = static_cast<int>(A.rows());
  const auto n = static_cast<int>(B.rows());
  const auto k = static_cast<int>(A.cols());
  const int lda = stride(A);
  const int ldb = stride(B);
  const int ldc = stride(C);
  dgemm_("N", "T", &m, &n, &k, &kMinusOne, A.data(), &lda, B.data(), &ldb, &beta, C.data(), &ldc);
}

}  // namespace mapjoin
