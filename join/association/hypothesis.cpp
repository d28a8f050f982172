// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/association/hypothesis.hpp>
#include <numbers>

namespace mapjoin {
namespace {

/// The logarithm of the odds of a difference with covariance S, whose squared Mahalanobis distance is d2, against another
/// feature there that is not known yet.
template <int Dim>
double gain(const Point<Dim>& difference, const PointMatrix<Dim>& S, double d2, double log_determinant,
            const NeighbourDensity<Dim>& density) {
  const double log_likelihood = -0.5 * (d2 + log_determinant + Dim * std::log(2.0 * std::numbers::pi));
  return log_likelihood - density.log_within(std::sqrt(difference.squaredNorm() + S.trace()));
}

/// The logarithm of the determinant of a matrix by its Cholesky factor.
template <int Dim>
double log_determinant(const Eigen::LLT<PointMatrix<Dim>>& factor) {
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

}  // namespace

template <int Dim>
PointMatrix<Dim> PairingProblem<Dim>::covariance_of(const Pairing& one, const Pairing& other) const {
  const auto block = [&](Eigen::Index row, Eigen::Index column) { return covariance.template block<Dim, Dim>(row, column); };
  const Eigen::Index a = row_of_known(one.known);
  const Eigen::Index b = row_of_sighting(one.sighting);
  const Eigen::Index c = row_of_known(other.known);
  const Eigen::Index d = row_of_sighting(other.sighting);
  return block(a, c) - block(a, d) - block(b, c) + block(b, d);
}

template <int Dim>
double PairingProblem<Dim>::log_overlooked(std::size_t known, double error) const {
  if (!sees) return 0.0;
  double sum = 0.0;
  for (const double distance : distances[known]) sum += sees->log_overlooked(distance, error);
  return sum;
}

template <int Dim>
std::optional<Extension<Dim>> extension_by(const Pairing& pairing, const Remainder<Dim>& left, Eigen::Index rows, double d2,
                                           const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates) {
  const Eigen::LLT<PointMatrix<Dim>> factor(left.covariance);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Point<Dim> whitened = factor.matrixL().solve(left.difference);
  const double own = whitened.squaredNorm();
  const bool is_within = own <= gates(Dim) && d2 + own <= gates(rows + Dim);  // false if the covariance is not finite
  if (!is_within) return std::nullopt;
  const double log_odds = gain<Dim>(left.difference, left.covariance, own, log_determinant<Dim>(factor), density);
  return Extension<Dim>{pairing, log_odds, left.covariance, whitened, {}};
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
  Remainder<Dim> left{problem_->difference(pairing), problem_->covariance_of(pairing, pairing)};
  left.covariance.noalias() -= coupling.transpose() * coupling;
  left.difference.noalias() -= coupling.transpose() * whitened_;
  auto extension = extension_by<Dim>(pairing, left, rows, squared_distance(), density, gates);
  if (extension) extension->coupling = std::move(coupling);
  return extension;
}

/// With L Lᵀ the covariance of all differences d and E the rows of the pairing, its information given the others is Zᵀ Z, with
/// Z = L⁻¹ E, and (Zᵀ Z)⁻¹ Zᵀ L⁻¹ d its difference. The rows of Z above E are zero.
template <int Dim>
std::optional<GivenOthers<Dim>> Hypothesis<Dim>::given_others(std::size_t place, const NeighbourDensity<Dim>& density,
                                                              ChiSquaredQuantiles& gates) const {
  const Eigen::Index rows = whitened_.size() - static_cast<Eigen::Index>(place) * Dim;
  Eigen::MatrixXd Z = Eigen::MatrixXd::Identity(rows, Dim);
  factor_.bottomRightCorner(rows, rows).template triangularView<Eigen::Lower>().solveInPlace(Z);
  const Eigen::LLT<PointMatrix<Dim>> factor(PointMatrix<Dim>(Z.transpose() * Z));
  const PointMatrix<Dim> S = factor.solve(PointMatrix<Dim>::Identity());
  const Point<Dim> weighted = Z.transpose() * whitened_.tail(rows);
  const Point<Dim> difference = S * weighted;
  const double d2 = weighted.dot(difference);
  if (!(d2 <= gates(Dim))) return std::nullopt;
  const double error = std::sqrt(gates(Dim) * S.trace());
  const double log_odds = gain<Dim>(difference, S, d2, -log_determinant<Dim>(factor), density) -
                          problem_->log_overlooked(pairings_[place].known, error);
  return GivenOthers<Dim>{log_odds, S};
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
ShiftGrowth<Dim> Hypothesis<Dim>::growth() const {
  Eigen::MatrixXd moved = PointMatrix<Dim>::Identity().replicate(static_cast<Eigen::Index>(pairings_.size()), 1);
  factor_.template triangularView<Eigen::Lower>().solveInPlace(moved);
  return {moved.transpose() * moved, moved.transpose() * whitened_};
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                   \
  template struct PairingProblem<Dim>;                                                                             \
  template std::optional<Extension<Dim>> extension_by(const Pairing&, const Remainder<Dim>&, Eigen::Index, double, \
                                                      const NeighbourDensity<Dim>&, ChiSquaredQuantiles&);         \
  template class Hypothesis<Dim>;
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
