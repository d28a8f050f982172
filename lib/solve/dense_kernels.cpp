// SPDX-License-Identifier: BSD-3-Clause
#include <dlfcn.h>

#include <mapjoin/solve/dense_kernels.hpp>
#include <mutex>

extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m, const int* n,
            const double* alpha, const double* a, const int* lda, double* b, const int* ldb);
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha, const double* a,
            const int* lda, const double* beta, double* c, const int* ldc);
void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c, const int* ldc);
}

namespace mapjoin {
namespace {

constexpr double kOne = 1.0;
constexpr double kMinusOne = -1.0;

/// A function that the BLAS in use may have, or null.
template <typename Function>
Function* loaded_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

/// Sets the number of OpenBLAS's threads only where it is another: to set it starts them again once they have been ended.
void put_openblas_on_one_thread() {
  auto* get_threads = loaded_function<int()>("openblas_get_num_threads");
  auto* set_threads = loaded_function<void(int)>("openblas_set_num_threads");
  if (get_threads && set_threads && get_threads() != 1) set_threads(1);
}

/// The BLAS for one call, on the calling thread alone. Threads are ours, over subtrees and tiles: those of the BLAS would be
/// too many, and its sums would depend on their number. OpenBLAS's own number holds for the process, OpenMP's for each thread;
/// and an OpenBLAS that was built without threads must not be called by two at once.
class Blas {
 public:
  Blas()
      : threads_before_(get_openmp_threads && set_openmp_threads ? get_openmp_threads() : 0), alone_(mutex_, std::defer_lock) {
    static const bool must_be_alone = [] {
      put_openblas_on_one_thread();
      auto* get_parallel = loaded_function<int()>("openblas_get_parallel");
      return get_parallel && get_parallel() == 0;
    }();
    if (threads_before_ > 1) set_openmp_threads(1);
    if (must_be_alone) alone_.lock();
  }
  ~Blas() {
    if (threads_before_ > 1) set_openmp_threads(threads_before_);
  }
  Blas(const Blas&) = delete;
  Blas& operator=(const Blas&) = delete;

 private:
  static inline auto* const get_openmp_threads = loaded_function<int()>("omp_get_max_threads");
  static inline auto* const set_openmp_threads = loaded_function<void(int)>("omp_set_num_threads");
  static inline std::mutex mutex_;
  int threads_before_;
  std::unique_lock<std::mutex> alone_;
};

int stride(const auto& block) {
  return static_cast<int>(block.outerStride());
}

double beta_of(Into into) {
  return into == Into::kSum ? 1.0 : 0.0;
}

}  // namespace

void end_blas_threads() {
  put_openblas_on_one_thread();
  if (auto* end_threads = loaded_function<int()>("blas_thread_shutdown_")) end_threads();
}

std::optional<Eigen::Index> cholesky_in_place(DenseBlock A) {
  const Blas blas;
  const auto n = static_cast<int>(A.rows());
  const int lda = stride(A);
  int info = 0;
  dpotrf_("L", &n, A.data(), &lda, &info);
  return info > 0 ? std::optional<Eigen::Index>(info - 1) : std::nullopt;
}

void divide_by_transpose(ConstDenseBlock L, DenseBlock B) {
  const Blas blas;
  const auto m = static_cast<int>(B.rows());
  const auto n = static_cast<int>(B.cols());
  const int lda = stride(L);
  const int ldb = stride(B);
  dtrsm_("R", "L", "T", "N", &m, &n, &kOne, L.data(), &lda, B.data(), &ldb);
}

void subtract_square(ConstDenseBlock B, DenseBlock C, Into into) {
  const Blas blas;
  const double beta = beta_of(into);
  const auto n = static_cast<int>(B.rows());
  const auto k = static_cast<int>(B.cols());
  const int lda = stride(B);
  const int ldc = stride(C);
  dsyrk_("L", "N", &n, &k, &kMinusOne, B.data(), &lda, &beta, C.data(), &ldc);
}

void subtract_product(ConstDenseBlock A, ConstDenseBlock B, DenseBlock C, Into into) {
  const Blas blas;
  const double beta = beta_of(into);
  const auto m = static_cast<int>(A.rows());
  const auto n = static_cast<int>(B.rows());
  const auto k = static_cast<int>(A.cols());
  const int lda = stride(A);
  const int ldb = stride(B);
  const int ldc = stride(C);
  dgemm_("N", "T", &m, &n, &k, &kMinusOne, A.data(), &lda, B.data(), &ldb, &beta, C.data(), &ldc);
}

std::string blas_name() {
  auto* config = loaded_function<char*()>("openblas_get_config");
  return config ? config() : "BLAS of the system";
}

}  // namespace mapjoin
