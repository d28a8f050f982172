// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/join/association/matching/hypothesis.hpp>
#include <numbers>
#include <numeric>

namespace mapjoin {
namespace {

/// The logarithm of the odds of a difference with covariance S, whose squared Mahalanobis distance is d2, against another
/// feature there that is not known yet.
template <int Dim>
double gain(const Point<Dim>& difference, const PointMatrix<Dim>& S, double d2, double log_determinant,
            const NeighbourDensity<Dim>& density) {
  const double log_likelihood = -0.5 * (d2 + log_determinant + Dim * std::log(2.0 * std::numbers::pi));
  return log_likelihood - density.log_within(difference.squaredNorm(), S.trace() / Dim);
}

/// The logarithm of the determinant of a matrix by its Cholesky factor.
template <int Dim>
double log_determinant(const Eigen::LLT<PointMatrix<Dim>>& factor) {
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

/// A difference, given others.
template <int Dim>
struct ConditionalDifference {
  Point<Dim> difference;        // (m)
  PointMatrix<Dim> covariance;  // (m²)
  double squared_distance;      // Mahalanobis; NaN if the covariance is not known
  double log_determinant;       // of the covariance
};

/// The information of the differences of pairings, which have a joint covariance L Lᵀ. Some can be taken out, as if nothing had
/// been known of them.
template <int Dim>
class DifferenceInformation {
 public:
  /// By L⁻¹, and L⁻¹ times the differences.
  DifferenceInformation(const Eigen::MatrixXd& inverse_factor, const Eigen::VectorXd& whitened)
      : information_(inverse_factor.transpose() * inverse_factor),
        weighted_(inverse_factor.transpose() * whitened),
        left_(static_cast<std::size_t>(whitened.size() / Dim)) {
    std::iota(left_.begin(), left_.end(), std::size_t{0});
  }

  /// The places of the pairings that have not been taken out, ascending.
  const std::vector<std::size_t>& left() const { return left_; }

  /// The difference of the pairing in this place, given all others left.
  ConditionalDifference<Dim> given_others(std::size_t place) const {
    const Eigen::Index row = static_cast<Eigen::Index>(place) * Dim;
    const Eigen::LLT<PointMatrix<Dim>> factor(PointMatrix<Dim>(information_.template block<Dim, Dim>(row, row)));
    const Point<Dim> weighted = weighted_.template segment<Dim>(row);
    const Point<Dim> difference = factor.solve(weighted);
    const bool is_known = factor.info() == Eigen::Success;
    return {difference, factor.solve(PointMatrix<Dim>::Identity()),
            is_known ? weighted.dot(difference) : std::numeric_limits<double>::quiet_NaN(), -log_determinant<Dim>(factor)};
  }

  void take_out(std::size_t place) {
    const ConditionalDifference<Dim> given = given_others(place);
    const Eigen::MatrixXd columns = information_.template middleCols<Dim>(static_cast<Eigen::Index>(place) * Dim);
    weighted_.noalias() -= columns * given.difference;
    information_.noalias() -= columns * given.covariance * columns.transpose();
    std::erase(left_, place);
  }

 private:
  Eigen::MatrixXd information_;
  Eigen::VectorXd weighted_;  // the information times the differences
  std::vector<std::size_t> left_;
};

/// The log odds that pairings are right, against other features there that are not known yet.
template <int Dim>
class PairingOdds {
 public:
  /// `log_overlooked`, by place: of the chance that another feature there was overlooked. The references must outlive this.
  PairingOdds(const NeighbourDensity<Dim>& density, const std::vector<double>& log_overlooked)
      : density_(density), log_overlooked_(log_overlooked) {}

  /// Those of a pairing, given all others left.
  double of(std::size_t place, const DifferenceInformation<Dim>& information) const {
    const auto [difference, covariance, d2, log_determinant] = information.given_others(place);
    return gain<Dim>(difference, covariance, d2, log_determinant, density_) - log_overlooked_[place];
  }

  /// Takes out, the weakest first, each pairing that is more probably of another feature, given those still left. Returns the
  /// sum of their log odds, all negative.
  double shed(DifferenceInformation<Dim>& information) const {
    double sum = 0.0;
    while (true) {
      double least = 0.0;
      std::size_t weakest = 0;
      for (const std::size_t k : information.left()) {
        const double log_odds = of(k, information);
        if (log_odds < least) {
          least = log_odds;
          weakest = k;
        }
      }
      if (least == 0.0) return sum;
      sum += least;
      information.take_out(weakest);
    }
  }

  /// Those of a pairing and of all that fall with it, together. Two wrong pairings may fit each other where neither fits the
  /// rest.
  double of_falling(std::size_t place, DifferenceInformation<Dim> information) const {
    const double own = of(place, information);
    information.take_out(place);
    return own + shed(information);
  }

 private:
  const NeighbourDensity<Dim>& density_;
  const std::vector<double>& log_overlooked_;
};

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

template <int Dim>
std::vector<std::optional<GivenOthers<Dim>>> Hypothesis<Dim>::given_others(const NeighbourDensity<Dim>& density,
                                                                           ChiSquaredQuantiles& gates) const {
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(whitened_.size(), whitened_.size());
  factor_.template triangularView<Eigen::Lower>().solveInPlace(inverse);
  const DifferenceInformation<Dim> all(inverse, whitened_);
  std::vector<double> log_overlooked;
  for (const std::size_t place : all.left()) {
    const double error = std::sqrt(gates(Dim) * all.given_others(place).covariance.trace());
    log_overlooked.push_back(problem_->log_overlooked(pairings_[place].known, error));
  }
  const PairingOdds<Dim> odds(density, log_overlooked);
  DifferenceInformation<Dim> sound = all;
  odds.shed(sound);
  std::vector<std::optional<GivenOthers<Dim>>> given;
  for (const std::size_t place : all.left()) {
    const auto left = all.given_others(place);
    const bool is_sound = std::ranges::binary_search(sound.left(), place);
    auto& found = given.emplace_back();
    if (!(left.squared_distance <= gates(Dim))) continue;
    found = {is_sound ? odds.of_falling(place, sound) : odds.of(place, all), left.covariance};
  }
  return given;
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
