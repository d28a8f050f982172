// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/join/association/matching/hypothesis.hpp>
#include <numbers>
#include <numeric>

namespace mapjoin {
namespace {

/// The logarithm of the density of a difference whose covariance has this determinant, at the squared Mahalanobis distance d2.
template <int Dim>
double log_likelihood(double d2, double log_determinant) {
  return -0.5 * (d2 + log_determinant + Dim * std::log(2.0 * std::numbers::pi));
}

/// The logarithm of the density of other features, not known yet, where a difference of covariance S puts them.
template <int Dim>
double log_others(const Point<Dim>& difference, const PointMatrix<Dim>& S, const NeighbourDensity<Dim>& density) {
  return density.log_within(difference.squaredNorm(), S.trace() / Dim);
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

/// The log odds that pairings are right, against other features there that are not known yet: one of the two was then
/// overlooked from each of the problem's distances.
template <int Dim>
class PairingOdds {
 public:
  /// `gate` is that of one pairing. The references must outlive this.
  PairingOdds(const PairingProblem<Dim>& problem, const std::vector<Pairing>& pairings, const NeighbourDensity<Dim>& density,
              double gate)
      : problem_(problem), pairings_(pairings), density_(density), gate_(gate) {}

  /// Those of a pairing, given all others left.
  double of(std::size_t place, const DifferenceInformation<Dim>& information) const {
    const ConditionalDifference<Dim> given = information.given_others(place);
    return log_likelihood<Dim>(given.squared_distance, given.log_determinant) - log_of_another(place, given);
  }

  /// Takes out, the weakest first, each pairing that is more probably of another feature, given those still left. Returns their
  /// places, in this order.
  std::vector<std::size_t> shed(DifferenceInformation<Dim>& information) const {
    std::vector<std::size_t> taken;
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
      if (least == 0.0) return taken;
      taken.push_back(weakest);
      information.take_out(weakest);
    }
  }

  /// Those of a pairing and of all that fall with it, together. Two wrong pairings may fit each other where neither fits the
  /// rest: the other features, of which they are then, stand where the rest alone puts them.
  double of_falling(std::size_t place, const DifferenceInformation<Dim>& information) const {
    DifferenceInformation<Dim> rest = information;
    rest.take_out(place);
    std::vector<std::size_t> fallen = shed(rest);
    if (fallen.empty()) return of(place, information);
    fallen.insert(fallen.begin(), place);
    DifferenceInformation<Dim> left = information;
    double sum = 0.0;
    for (const std::size_t k : fallen) {
      const ConditionalDifference<Dim> given = left.given_others(k);
      sum += log_likelihood<Dim>(given.squared_distance, given.log_determinant) -
             log_of_another(k, given_rest(k, fallen, information));
      left.take_out(k);
    }
    return sum;
  }

 private:
  /// The difference of one of the fallen, given all that have not fallen.
  ConditionalDifference<Dim> given_rest(std::size_t place, const std::vector<std::size_t>& fallen,
                                        DifferenceInformation<Dim> information) const {
    for (const std::size_t k : fallen) {
      if (k != place) information.take_out(k);
    }
    return information.given_others(place);
  }

  /// The logarithm of the density of another feature there, and of the chance that one of the two was overlooked.
  double log_of_another(std::size_t place, const ConditionalDifference<Dim>& given) const {
    const double error = std::sqrt(gate_ * given.covariance.trace());
    return log_others<Dim>(given.difference, given.covariance, density_) +
           problem_.log_overlooked(pairings_[place].known, error);
  }

  const PairingProblem<Dim>& problem_;
  const std::vector<Pairing>& pairings_;
  const NeighbourDensity<Dim>& density_;
  double gate_;
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
  const double gain =
      log_likelihood<Dim>(own, log_determinant<Dim>(factor)) - log_others<Dim>(left.difference, left.covariance, density);
  return Extension<Dim>{pairing, gain, left.covariance, whitened, {}};
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
  const PairingOdds<Dim> odds(*problem_, pairings_, density, gates(Dim));
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
KnownAndSightings Hypothesis<Dim>::without_partner(const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates) const {
  KnownAndSightings alone;
  std::vector<bool> has_partner(problem_->known.size(), false);
  for (const Pairing& pairing : pairings_) has_partner[pairing.known] = true;
  for (std::size_t s = 0; s < known_of_.size(); ++s) {
    if (known_of_[s]) continue;
    bool is_alone = true;
    for (const std::size_t k : problem_->choices[s]) {
      if (!extension({k, s}, density, gates)) continue;
      has_partner[k] = true;
      is_alone = false;
    }
    if (is_alone) alone.sightings.push_back(s);
  }
  for (std::size_t k = 0; k < has_partner.size(); ++k) {
    if (!has_partner[k]) alone.known.push_back(k);
  }
  return alone;
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
