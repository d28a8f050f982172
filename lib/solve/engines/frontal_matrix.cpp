// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/engines/frontal_matrix.hpp>
#include <mapjoin/solve/sparse_solver.hpp>
#include <mutex>
#include <utility>

extern "C" {
// The Fortran interface, which every BLAS and LAPACK has.
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m, const int* n,
            const double* alpha, const double* a, const int* lda, double* b, const int* ldb);
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha, const double* a,
            const int* lda, const double* beta, double* c, const int* ldc);
void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c, const int* ldc);
// Null if the BLAS is not OpenBLAS, or if nothing in the process uses OpenMP.
[[gnu::weak]] int openblas_get_parallel();
[[gnu::weak]] int omp_get_max_threads();
[[gnu::weak]] void omp_set_num_threads(int);
}

namespace mapjoin {
namespace {

constexpr double kOne = 1.0;
constexpr double kMinusOne = -1.0;

/// The scope of a BLAS call. It keeps a BLAS on OpenMP on the calling thread (OpenMP's number of threads belongs to the thread
/// that sets it), and lets only one thread at a time call an OpenBLAS built without threads.
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
  int openmp_threads_;  ///< OpenMP's threads before the call.
  std::unique_lock<std::mutex> alone_;
};

/// A block as Fortran takes it: all arguments are addresses.
template <typename Block>
struct Argument {
  explicit Argument(Block& block)
      : data(block.data()),
        rows(static_cast<int>(block.rows())),
        columns(static_cast<int>(block.cols())),
        stride(static_cast<int>(block.outerStride())) {}
  decltype(std::declval<Block&>().data()) data;
  int rows;
  int columns;
  int stride;
};

double beta_of(Into into) {
  return into == Into::kSum ? 1.0 : 0.0;
}

}  // namespace

std::optional<Eigen::Index> cholesky_in_place(DenseBlock A) {
  const BlasCall call;
  const Argument a(A);
  int info = 0;
  dpotrf_("L", &a.rows, a.data, &a.stride, &info);
  return info > 0 ? std::optional<Eigen::Index>(info - 1) : std::nullopt;
}

void divide_by_transpose(ConstDenseBlock L, DenseBlock B) {
  const BlasCall call;
  const Argument l(L);
  const Argument b(B);
  dtrsm_("R", "L", "T", "N", &b.rows, &b.columns, &kOne, l.data, &l.stride, b.data, &b.stride);
}

void subtract_square(ConstDenseBlock B, DenseBlock C, Into into) {
  const BlasCall call;
  const Argument b(B);
  const Argument c(C);
  const double beta = beta_of(into);
  dsyrk_("L", "N", &b.rows, &b.columns, &kMinusOne, b.data, &b.stride, &beta, c.data, &c.stride);
}

void subtract_product(ConstDenseBlock A, ConstDenseBlock B, DenseBlock C, Into into) {
  const BlasCall call;
  const Argument a(A);
  const Argument b(B);
  const Argument c(C);
  const double beta = beta_of(into);
  dgemm_("N", "T", &a.rows, &b.rows, &a.columns, &kMinusOne, a.data, &a.stride, b.data, &b.stride, &beta, c.data, &c.stride);
}

namespace {

/// The number of columns that are eliminated at once, and of columns or rows in a piece of work: large enough for the BLAS,
/// small enough to be shared out.
constexpr Eigen::Index kTile = 192;

DenseBlock part(DenseBlock block, Eigen::Index row, Eigen::Index column, Eigen::Index rows, Eigen::Index columns) {
  return {block.data() + row + column * block.outerStride(), rows, columns, Eigen::OuterStride<>(block.outerStride())};
}

/// Calls f(begin, size) for each of the tiles that make up [0, size).
template <typename F>
void for_each_tile(Eigen::Index size, F&& f) {
  parallel_for(static_cast<std::size_t>((size + kTile - 1) / kTile), [&](std::size_t k) {
    const auto begin = static_cast<Eigen::Index>(k) * kTile;
    f(begin, std::min(kTile, size - begin));
  });
}

/// Computes the lower trapezoid of C - B B_Cᵀ, over the columns that C has; B_C are the first rows of B.
void subtract_square_by_tiles(DenseBlock B, DenseBlock C, Into into) {
  for_each_tile(C.cols(), [&](Eigen::Index begin, Eigen::Index size) {
    const DenseBlock rows = part(B, begin, 0, size, B.cols());
    subtract_square(constant(rows), part(C, begin, begin, size, size), into);
    const Eigen::Index below = B.rows() - begin - size;
    if (below == 0) return;
    subtract_product(constant(part(B, begin + size, 0, below, B.cols())), constant(rows),
                     part(C, begin + size, begin, below, size), into);
  });
}

/// Factorises a small matrix column by column; singular columns become those of the identity and are noted.
void factorise_leaving_out(DenseBlock A, const Eigen::Ref<const Eigen::VectorXd>& diagonal,
                           std::vector<Eigen::Index>& singular) {
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    const Eigen::Index below = A.rows() - j - 1;
    auto column = A.col(j).tail(below);
    const double pivot = std::sqrt(std::max(A(j, j), 0.0));
    if (has_lost_digits(pivot, diagonal[j])) {
      singular.push_back(j);
      A(j, j) = 1.0;
      column.setZero();
      continue;
    }
    A(j, j) = pivot;
    column /= pivot;
    A.bottomRightCorner(below, below).selfadjointView<Eigen::Lower>().rankUpdate(column, -1.0);
  }
}

/// Performs factorise_leaving_out(), by LAPACK if no column is singular; returns the singular columns.
std::vector<Eigen::Index> factorise_tile(DenseBlock A, const Eigen::Ref<const Eigen::VectorXd>& diagonal) {
  const Eigen::MatrixXd before = A;
  std::vector<Eigen::Index> singular;
  bool is_regular = !cholesky_in_place(A);
  for (Eigen::Index j = 0; is_regular && j < A.cols(); ++j) is_regular = !has_lost_digits(A(j, j), diagonal[j]);
  if (is_regular) return singular;
  A = before;
  factorise_leaving_out(A, diagonal, singular);
  return singular;
}

}  // namespace

void add_update(ConstDenseBlock update, std::span<const RowRun> runs, Eigen::Index begin, DenseBlock block) {
  for (std::size_t c = 0; c < runs.size(); ++c) {
    for (std::int32_t j = 0; j < runs[c].length; ++j) {
      const Eigen::Index column = runs[c].to + j - begin;
      if (column < 0) continue;
      if (column >= block.cols()) return;
      const double* from = update.data() + (runs[c].from + j) * update.outerStride();
      double* to = block.data() + column * block.outerStride();
      for (std::int32_t i = j; i < runs[c].length; ++i) to[runs[c].to + i - begin] += from[runs[c].from + i];
      for (const RowRun& run : runs.subspan(c + 1)) {
        for (std::int32_t i = 0; i < run.length; ++i) to[run.to + i - begin] += from[run.from + i];
      }
    }
  }
}

std::vector<Eigen::Index> eliminate(FrontalMatrix front, const Eigen::VectorXd& diagonal) {
  const Eigen::Index height = front.panel.rows();
  const Eigen::Index width = front.panel.cols();
  std::vector<Eigen::Index> singular;
  for (Eigen::Index begin = 0; begin < width; begin += kTile) {
    const Eigen::Index columns = std::min(kTile, width - begin);
    const DenseBlock tile = part(front.panel, begin, begin, columns, columns);
    const auto of_tile = factorise_tile(tile, diagonal.segment(begin, columns));
    const Eigen::Index end = begin + columns;
    for_each_tile(height - end, [&](Eigen::Index row, Eigen::Index rows) {
      divide_by_transpose(constant(tile), part(front.panel, end + row, begin, rows, columns));
    });
    for (const Eigen::Index column : of_tile) {
      front.panel.col(begin + column).tail(height - end).setZero();
      singular.push_back(begin + column);
    }
    if (end == width) break;
    subtract_square_by_tiles(part(front.panel, end, begin, height - end, columns),
                             part(front.panel, end, end, height - end, width - end), Into::kSum);
  }
  if (height > width) {
    subtract_square_by_tiles(part(front.panel, width, 0, height - width, width), front.update, Into::kNew);
  }
  return singular;
}

}  // namespace mapjoin
