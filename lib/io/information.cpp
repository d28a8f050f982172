// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <mapjoin/io/information.hpp>

namespace mapjoin {
namespace {

/// Relative to the largest entry or eigenvalue: above the round-off of a factorisation, below any deliberate figure.
constexpr double kRoundOff = 1e-9;

/// Halved first: the sum of two finite numbers may not be one.
template <int Size>
Matrix<Size> symmetric_part(const Matrix<Size>& M) {
  return 0.5 * M + 0.5 * M.transpose();
}

/// In Frobenius norm: eigenvalues clipped at zero.
Eigen::MatrixXd nearest_semidefinite(const Eigen::MatrixXd& W) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(W);
  const Eigen::MatrixXd& V = eigen.eigenvectors();
  return symmetric_part<Eigen::Dynamic>(V * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * V.transpose());
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

template <int Size>
std::optional<std::string> make_symmetric(Matrix<Size>& M) {
  if (!M.allFinite()) return "is not finite";
  const double asymmetry = (M - M.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > kRoundOff * M.cwiseAbs().maxCoeff()) {
    return fmt::format("is not symmetric (entries across the diagonal differ by up to {:.6g})", asymmetry);
  }
  if (asymmetry > 0.0) M = symmetric_part<Size>(M);
  return std::nullopt;
}

template <int Size>
std::optional<std::string> InformationCheck::fault(Matrix<Size>& W) {
  if (const auto fault = make_symmetric<Size>(W)) return fault;
  if (Eigen::LLT<Matrix<Size>>(W).info() == Eigen::Success) return std::nullopt;

  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(W, Eigen::EigenvaluesOnly);
  const double smallest = eigen.eigenvalues()[0];
  const double largest = eigen.eigenvalues()[W.rows() - 1];
  if (smallest >= -kRoundOff * largest) return std::nullopt;
  if (!repair_) return fmt::format("is indefinite (eigenvalues from {:.6g} to {:.6g})", smallest, largest);
  W = nearest_semidefinite(W);
  if (!W.allFinite()) return "is indefinite and too large to be repaired";
  ++repaired_;
  return std::nullopt;
}

template std::optional<Matrix<2>> information_of_covariance<2>(const Matrix<2>&);
template std::optional<std::string> make_symmetric<2>(Matrix<2>&);
template std::optional<std::string> InformationCheck::fault<2>(Matrix<2>&);

template std::optional<Matrix<3>> information_of_covariance<3>(const Matrix<3>&);
template std::optional<std::string> make_symmetric<3>(Matrix<3>&);
template std::optional<std::string> InformationCheck::fault<3>(Matrix<3>&);

template std::optional<Matrix<6>> information_of_covariance<6>(const Matrix<6>&);
template std::optional<std::string> make_symmetric<6>(Matrix<6>&);
template std::optional<std::string> InformationCheck::fault<6>(Matrix<6>&);

template std::optional<Matrix<Eigen::Dynamic>> information_of_covariance<Eigen::Dynamic>(const Matrix<Eigen::Dynamic>&);
template std::optional<std::string> make_symmetric<Eigen::Dynamic>(Matrix<Eigen::Dynamic>&);
template std::optional<std::string> InformationCheck::fault<Eigen::Dynamic>(Matrix<Eigen::Dynamic>&);

}  // namespace mapjoin
