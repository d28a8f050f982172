// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <limits>
#include <mapjoin/model/information.hpp>

namespace mapjoin {
namespace {

/// Round-off, relative to the largest entry, eigenvalue or diagonal entry of a row: above that of a factorisation, below any
/// deliberate figure.
constexpr double kRoundOff = 1e-9;
/// Round-off, relative to the largest entry, that turning, marginalising or repairing a matrix leaves in rows of much smaller
/// entries, such as those that are not measured.
constexpr double kLeastRoundOff = 1e-13;
/// The asymmetry, relative to the largest entry, that a filter's covariance update leaves after thousands of steps.
constexpr double kMostAsymmetry = 1e-6;

/// The symmetric part; halved first, since the sum of two finite numbers may overflow.
template <int Size>
Matrix<Size> symmetric_part(const Matrix<Size>& M) {
  return 0.5 * M + 0.5 * M.transpose();
}

/// True if W is positive semidefinite up to round-off: definite with every diagonal entry raised by 1e-9 of itself and 1e-13 of
/// the largest entry, so that metres and radians weigh alike.
template <int Size>
bool is_semidefinite(const Matrix<Size>& W) {
  if (W.isZero(0.0)) return true;
  Matrix<Size> raised = W;
  raised.diagonal().array() += kRoundOff * W.diagonal().array().max(0.0) + kLeastRoundOff * W.cwiseAbs().maxCoeff();
  return Eigen::LLT<Matrix<Size>>(raised).info() == Eigen::Success;
}

/// The eigensolver, of dynamic size: one unrolled for each size takes long to compile, and few matrices need it.
using EigenSolver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

/// The nearest symmetric matrix, in Frobenius norm, with no eigenvalue below `least` of the largest.
Eigen::MatrixXd lifted(const Eigen::MatrixXd& M, double least) {
  const EigenSolver eigen(M);
  const Eigen::MatrixXd& V = eigen.eigenvectors();
  const double floor = std::max(0.0, least * eigen.eigenvalues()[M.rows() - 1]);
  return symmetric_part<Eigen::Dynamic>(V * eigen.eigenvalues().cwiseMax(floor).asDiagonal() * V.transpose());
}

/// The covariance with its correlations made positive definite, so that metres and radians are lifted alike. Not finite if a
/// variance is not positive.
Eigen::MatrixXd definite(const Eigen::MatrixXd& P) {
  const Eigen::VectorXd deviation = P.diagonal().cwiseSqrt();
  const Eigen::VectorXd scale = deviation.cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * P * scale.asDiagonal();
  return deviation.asDiagonal() * lifted(correlation, kRoundOff) * deviation.asDiagonal();
}

}  // namespace

template <int Size>
std::optional<Matrix<Size>> information_of_covariance(const Matrix<Size>& covariance) {
  if (!covariance.allFinite()) return std::nullopt;
  const Eigen::LLT<Matrix<Size>> llt(covariance);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const Matrix<Size> inverse = llt.solve(Matrix<Size>::Identity(covariance.rows(), covariance.cols()));
  if (!inverse.allFinite()) return std::nullopt;
  return symmetric_part<Size>(inverse);
}

std::string InformationCheck::refusal(std::string fault, const char* remedy) const {
  return offer_ ? fmt::format("{}; --repair-information takes {}", fault, remedy) : fault;
}

template <int Size>
std::optional<std::string> InformationCheck::make_symmetric(Matrix<Size>& M) {
  if (!M.allFinite()) return "is not finite";
  const double asymmetry = (M - M.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry == 0.0) return std::nullopt;
  const double relative = asymmetry / M.cwiseAbs().maxCoeff();
  if (relative > kMostAsymmetry && !repair_) {
    return refusal(
        fmt::format("is not symmetric (entries across the diagonal differ by up to {:.2g} of the largest)", relative),
        "its symmetric part");
  }
  M = symmetric_part<Size>(M);
  if (relative > kRoundOff) repairs_ += {.symmetrised = 1, .largest_asymmetry = relative};
  return std::nullopt;
}

template <int Size>
std::optional<std::string> InformationCheck::fault(Matrix<Size>& W) {
  if (W.size() == 0) return std::nullopt;
  if (const auto fault = make_symmetric<Size>(W)) return fault;
  if (is_semidefinite<Size>(W)) return std::nullopt;
  if (!repair_) {
    const EigenSolver eigen(W, Eigen::EigenvaluesOnly);
    return refusal(fmt::format("is indefinite (eigenvalues from {:.6g} to {:.6g})", eigen.eigenvalues()[0],
                               eigen.eigenvalues()[W.rows() - 1]),
                   "the nearest semidefinite one");
  }
  W = lifted(W, 0.0);
  if (!W.allFinite()) return "is indefinite and too large to be repaired";
  repairs_ += {.indefinite = 1};
  return std::nullopt;
}

template <int Size>
std::optional<std::string> InformationCheck::invert(Matrix<Size>& covariance) {
  if (covariance.size() == 0) return std::nullopt;
  if (const auto fault = make_symmetric<Size>(covariance)) return fault;
  auto W = information_of_covariance<Size>(covariance);
  if (!W && repair_) {
    W = information_of_covariance<Size>(Matrix<Size>(definite(covariance)));
    repairs_ += {.indefinite = 1};
  }
  if (!W) return refusal("is not positive definite", "the nearest one that is, where variances are positive");
  covariance = *W;
  return std::nullopt;
}

template <int Rows>
UnitScaled<Rows> unit_scaled(const Matrix<Rows>& W) {
  const Vector<Rows> diagonal = W.diagonal();
  const Vector<Rows> scale = (diagonal.array() > 0.0).select(diagonal.array().rsqrt(), 0.0);
  const double of_factorisation = static_cast<double>(W.rows()) * std::numeric_limits<double>::epsilon();
  return {scale, scale.asDiagonal() * W * scale.asDiagonal(), Rows == Eigen::Dynamic ? of_factorisation : kRoundOff};
}

template <int Rows>
std::int64_t information_rank(const Matrix<Rows>& W) {
  const UnitScaled<Rows> scaled = unit_scaled<Rows>(W);
  return (Eigen::LDLT<Matrix<Rows>>(scaled.W).vectorD().array() > scaled.rounding).count();
}

template <int Rows>
Matrix<Rows> measured_identity(const Matrix<Rows>& W) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < W.rows(); ++i) {
    if (W(i, i) > 0.0) rows.push_back(i);
  }
  const auto rank = static_cast<Eigen::Index>(information_rank<Rows>(W));
  Eigen::MatrixXd projector = Eigen::MatrixXd::Identity(std::ssize(rows), std::ssize(rows));
  if (rank < std::ssize(rows)) {
    const Matrix<Rows> range = W * unit_scaled<Rows>(W).scale.asDiagonal();
    const Eigen::MatrixXd Q = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(range(rows, rows)).householderQ();
    projector = Q.leftCols(rank) * Q.leftCols(rank).transpose();
  }
  Matrix<Rows> identity = Matrix<Rows>::Zero(W.rows(), W.cols());
  identity(rows, rows) = projector;
  return identity;
}

Eigen::MatrixXd marginal_information(const Eigen::MatrixXd& W, const std::vector<Eigen::Index>& L,
                                     const std::vector<Eigen::Index>& N) {
  const Eigen::MatrixXd W_LL = W(L, L);
  if (N.empty() || L.empty()) return W_LL;
  const Eigen::MatrixXd W_NL = W(N, L);
  return symmetric_part<Eigen::Dynamic>(W_LL - W_NL.transpose() * Eigen::MatrixXd(W(N, N)).ldlt().solve(W_NL));
}

#define MAPJOIN_INSTANTIATE(Size)                                                            \
  template std::optional<Matrix<Size>> information_of_covariance<Size>(const Matrix<Size>&); \
  template UnitScaled<Size> unit_scaled<Size>(const Matrix<Size>&);                          \
  template std::int64_t information_rank<Size>(const Matrix<Size>&);                         \
  template Matrix<Size> measured_identity<Size>(const Matrix<Size>&);                        \
  template std::optional<std::string> InformationCheck::fault<Size>(Matrix<Size>&);          \
  template std::optional<std::string> InformationCheck::invert<Size>(Matrix<Size>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
MAPJOIN_INSTANTIATE(6)
MAPJOIN_INSTANTIATE(Eigen::Dynamic)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
