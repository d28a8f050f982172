// SPDX-License-Identifier: BSD-3-Clause
// SparseCholesky by Eigen's SimplicialLLT, for builds without CHOLMOD.
#ifndef MAPJOIN_CHOLMOD
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <mapjoin/solve/pivot.hpp>
#include <mapjoin/solve/sparse_cholesky.hpp>

namespace mapjoin {
namespace {

using EigenSparse = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int64_t>;

EigenSparse copy(const SparseUpper& matrix) {
  return Eigen::Map<const EigenSparse>(matrix.size(), matrix.size(), static_cast<Eigen::Index>(matrix.rows.size()),
                                       matrix.column_begin.data(), matrix.rows.data(), matrix.values.data());
}

}  // namespace

struct SparseCholesky::Factor {
  Eigen::SimplicialLLT<EigenSparse, Eigen::Upper, Eigen::NaturalOrdering<std::int64_t>> llt;
};

SparseCholesky::SparseCholesky() = default;
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyse(const SparseUpper& matrix) {
  factor_ = std::make_unique<Factor>();
  factor_->llt.analyzePattern(copy(matrix));
}

std::optional<std::int64_t> SparseCholesky::factorise(const SparseUpper& matrix) {
  const EigenSparse A = copy(matrix);
  factor_->llt.factorize(A);
  const bool regular = factor_->llt.info() == Eigen::Success;
  const Eigen::VectorXd pivots = EigenSparse(factor_->llt.matrixL()).diagonal();
  const Eigen::VectorXd diagonal = A.diagonal();
  for (Eigen::Index j = 0; j < pivots.size(); ++j) {
    if (has_lost_digits(pivots[j], diagonal[j])) return j;
  }
  if (!regular) return pivots.size() - 1;
  return std::nullopt;
}

Eigen::MatrixXd SparseCholesky::solve_columns(const Eigen::MatrixXd& B) const {
  return factor_->llt.solve(B);
}

Supernodes SparseCholesky::supernodes() const {
  const EigenSparse& L = factor_->llt.matrixL().nestedExpression();
  Supernodes factor;
  for (std::int64_t j = 0; j < L.cols(); ++j) {
    const std::int64_t begin = L.outerIndexPtr()[j];
    const auto height = static_cast<std::size_t>(L.outerIndexPtr()[j + 1] - begin);
    factor.nodes.push_back({j, j + 1, {L.innerIndexPtr() + begin, height}, L.valuePtr() + begin});
    factor.places.push_back(j);
  }
  return factor;
}

std::string blas_name() {
  return "none (Eigen)";
}

}  // namespace mapjoin
#endif
