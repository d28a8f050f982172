// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/association/hypothesis.hpp>
#include <numbers>

namespace mapjoin {

template <int Dim>
PointMatrix<Dim> PairingProblem<Dim>::covariance_of(const Pairing& one, const Pairing& other) const {
  const auto row = [](std::size_t point) { return static_cast<Eigen::Index>(point) * Dim; };
  const auto block = [&](std::size_t i, std::size_t j) { return covariance.template block<Dim, Dim>(row(i), row(j)); };
  const std::size_t a = one.known;
  const std::size_t b = known.size() + one.sighting;
  const std::size_t c = other.known;
  const std::size_t d = known.size() + other.sighting;
  return block(a, c) - block(a, d) - block(b, c) + block(b, d);
}

template <int Dim>
bool Hypothesis<Dim>::takes(std::size_t known) const {
  return std::ranges::any_of(pairings_, [known](const Pairing& p) { return p.known == known; });
}

template <int Dim>
std::optional<Extension<Dim>> Hypothesis<Dim>::extension(const Pairing& pairing, const NeighbourDensity<Dim>& density,
                                                         ChiSquaredQuantiles& gates) const {
  const Eigen::Index rows = whitened_.size();
  Eigen::MatrixXd coupling(rows, Dim);
  for (std::size_t k = 0; k < pairings_.size(); ++k) {
    coupling.middleRows<Dim>(static_cast<Eigen::Index>(k) * Dim) = problem_->covariance_of(pairings_[k], pairing);
  }
  factor_.template triangularView<Eigen::Lower>().solveInPlace(coupling);
  PointMatrix<Dim> S = problem_->covariance_of(pairing, pairing);
  S.noalias() -= coupling.transpose() * coupling;
  Point<Dim> difference = problem_->difference(pairing);
  difference.noalias() -= coupling.transpose() * whitened_;
  const Eigen::LLT<PointMatrix<Dim>> factor(S);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Point<Dim> whitened = factor.matrixL().solve(difference);
  const double d2 = whitened.squaredNorm();
  const bool is_within = d2 <= gates(Dim) && squared_distance() + d2 <= gates(rows + Dim);  // false if S is not finite
  if (!is_within) return std::nullopt;
  const double log_determinant = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  const double log_likelihood = -0.5 * (d2 + log_determinant + Dim * std::log(2.0 * std::numbers::pi));
  const double apart = std::sqrt(difference.squaredNorm() + S.trace());
  return Extension<Dim>{pairing, log_likelihood - density.log_within(apart), S, whitened, std::move(coupling)};
}

template <int Dim>
void Hypothesis<Dim>::extend(const Extension<Dim>& extension) {
  const Eigen::Index rows = whitened_.size();
  factor_.conservativeResize(rows + Dim, rows + Dim);
  factor_.rightCols(Dim).setZero();
  factor_.bottomLeftCorner(Dim, rows) = extension.coupling.transpose();
  factor_.template bottomRightCorner<Dim, Dim>() = extension.covariance.llt().matrixL();
  whitened_.conservativeResize(rows + Dim);
  whitened_.template tail<Dim>() = extension.whitened;
  known_of_[extension.pairing.sighting] = extension.pairing.known;
  pairings_.push_back(extension.pairing);
  score_ += extension.gain;
}

template <int Dim>
void Hypothesis<Dim>::extend_by(const std::vector<Pairing>& pairings, const NeighbourDensity<Dim>& density,
                                ChiSquaredQuantiles& gates) {
  for (const Pairing& pairing : pairings) {
    if (known_of_[pairing.sighting] || takes(pairing.known)) continue;
    if (const auto added = extension(pairing, density, gates)) extend(*added);
  }
}

template <int Dim>
double Hypothesis<Dim>::growth(const Point<Dim>& shift) const {
  const Eigen::VectorXd shifts = shift.replicate(static_cast<Eigen::Index>(pairings_.size()), 1);
  const Eigen::VectorXd moved = factor_.template triangularView<Eigen::Lower>().solve(shifts);
  return (whitened_ + moved).squaredNorm() - whitened_.squaredNorm();
}

#define MAPJOIN_INSTANTIATE(Dim)       \
  template struct PairingProblem<Dim>; \
  template class Hypothesis<Dim>;
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
