// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The BLAS and LAPACK of the machine, found while the program runs.

#include <stdexcept>
#include <string>

namespace mapjoin {

/// The machine has no LAPACK, or cannot load it: what() says why.
struct NoLapack : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Routines by their Fortran interface, where every argument is an address.
struct Blas {
  void (*potrf)(const char* uplo, const int* n, double* a, const int* lda, int* info);
  void (*trsm)(const char* side, const char* uplo, const char* trans, const char* diag, const int* m, const int* n,
               const double* alpha, const double* a, const int* lda, double* b, const int* ldb);
  void (*syrk)(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha, const double* a,
               const int* lda, const double* beta, double* c, const int* ldc);
  void (*gemm)(const char* transa, const char* transb, const int* m, const int* n, const int* k, const double* alpha,
               const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c, const int* ldc);
  /// The number of OpenMP's threads; both null where the BLAS does not use them.
  int (*get_openmp_threads)();
  void (*set_openmp_threads)(int);
  bool must_be_alone;  ///< Whether no two threads may call it at once.
  std::string name;    ///< For the report.
};

/// What the program has loaded already, or else OpenBLAS, or else any LAPACK; kept to one thread for the whole process. The
/// first call takes some milliseconds: OpenBLAS has fourteen thousand symbols to resolve. Throws NoLapack.
const Blas& blas();

}  // namespace mapjoin
