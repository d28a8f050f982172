// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <limits>
#include <mapjoin/join/association/alignment_branch.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The pairings that determine where a map lies: the one farthest from the middle of all, then those farthest from the ones
/// chosen before.
template <int Dim>
std::vector<FeaturePair> far_apart(const std::vector<FeaturePair>& pairs, const CovarianceColumns<Dim>& covariances) {
  const auto position = [&](const FeaturePair& p) { return covariances.position(p.other); };
  Point<Dim> middle = Point<Dim>::Zero();
  for (const FeaturePair& p : pairs) middle += position(p) / static_cast<double>(pairs.size());
  std::vector<FeaturePair> chosen;
  while (chosen.size() < std::min(AlignmentBranch<Dim>::kFewest, pairs.size())) {
    const auto apart = [&](const FeaturePair& p) {
      if (chosen.empty()) return (position(p) - middle).squaredNorm();
      double least = std::numeric_limits<double>::infinity();
      for (const FeaturePair& other : chosen) least = std::min(least, (position(p) - position(other)).squaredNorm());
      return least;
    };
    chosen.push_back(*std::ranges::max_element(pairs, {}, apart));
  }
  return chosen;
}

}  // namespace

template <int Dim>
CovarianceColumns<Dim>::CovarianceColumns(const FeatureEstimate<Dim>& estimate)
    : estimate_(&estimate), columns_(estimate.covariances->state().features.size()) {}

template <int Dim>
void CovarianceColumns<Dim>::add(std::span<const FeatureIndex> features) {
  std::vector<FeatureIndex> missing;
  std::ranges::copy_if(features, std::back_inserter(missing), [&](FeatureIndex f) { return columns_[f].size() == 0; });
  if (missing.empty()) return;
  const NormalEquations& equations = estimate_->covariances->equations();
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(equations.size(), static_cast<Eigen::Index>(missing.size()) * Dim);
  const auto column = [](std::size_t k) { return static_cast<Eigen::Index>(k) * Dim; };
  for (std::size_t k = 0; k < missing.size(); ++k) {
    unit.template block<Dim, Dim>(offset(missing[k]), column(k)).setIdentity();
  }
  const Eigen::MatrixXd solved = estimate_->scale * equations.solve_columns(unit);
  for (std::size_t k = 0; k < missing.size(); ++k) columns_[missing[k]] = solved.middleCols<Dim>(column(k));
}

template <int Dim>
void CovarianceColumns<Dim>::keep(const std::vector<FeatureIndex>& features) {
  std::vector<bool> is_kept(columns_.size(), false);
  for (const FeatureIndex f : features) is_kept[f.position()] = true;
  for (const FeatureIndex f : indices(columns_)) {
    if (!is_kept[f.position()]) columns_[f] = {};
  }
}

template <int Dim>
Eigen::MatrixXd AlignmentBranch<Dim>::coupling(std::span<const FeaturePair> differences,
                                               const CovarianceColumns<Dim>& covariances, const Eigen::MatrixXd& above) const {
  const Eigen::Index first = above.rows();
  const auto rows = static_cast<Eigen::Index>(held_.size()) * Dim;
  Eigen::MatrixXd coupling(rows, static_cast<Eigen::Index>(differences.size()) * Dim);
  coupling.topRows(first) = above;
  for (Eigen::Index row = first; row < rows; row += Dim) {
    const FeaturePair& held = held_[static_cast<std::size_t>(row / Dim)];
    for (std::size_t k = 0; k < differences.size(); ++k) {
      const auto& [one, other] = differences[k];
      coupling.template block<Dim, Dim>(row, static_cast<Eigen::Index>(k) * Dim) =
          (covariances.between(one, held.one) - covariances.between(one, held.other) - covariances.between(other, held.one) +
           covariances.between(other, held.other))
              .transpose();
    }
  }
  auto below = coupling.bottomRows(rows - first);
  below.noalias() -= factor_.bottomLeftCorner(rows - first, first) * above;
  factor_.bottomRightCorner(rows - first, rows - first).template triangularView<Eigen::Lower>().solveInPlace(below);
  return coupling;
}

template <int Dim>
PairingProblem<Dim> AlignmentBranch<Dim>::problem(std::span<const FeatureIndex> known, std::span<const FeatureIndex> sightings,
                                                  const CovarianceColumns<Dim>& covariances) const {
  std::vector<FeatureIndex> all(known.begin(), known.end());
  all.insert(all.end(), sightings.begin(), sightings.end());
  const auto at = [](std::size_t k) { return static_cast<Eigen::Index>(k) * Dim; };
  Eigen::MatrixXd with_held(at(held_.size()), at(all.size()));
  PairingProblem<Dim> problem;
  problem.covariance.resize(at(all.size()), at(all.size()));
  for (std::size_t k = 0; k < all.size(); ++k) {
    for (std::size_t h = 0; h < held_.size(); ++h) {
      with_held.template block<Dim, Dim>(at(h), at(k)) =
          (covariances.between(all[k], held_[h].one) - covariances.between(all[k], held_[h].other)).transpose();
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
      problem.covariance.template block<Dim, Dim>(at(i), at(k)) = covariances.between(all[i], all[k]);
    }
  }
  factor_.template triangularView<Eigen::Lower>().solveInPlace(with_held);
  problem.covariance.noalias() -= with_held.transpose() * with_held;
  const Eigen::VectorXd moved = expected(with_held);
  for (std::size_t k = 0; k < all.size(); ++k) {
    (k < known.size() ? problem.known : problem.sightings)
        .push_back(covariances.position(all[k]) + moved.template segment<Dim>(at(k)));
  }
  problem.choices.resize(sightings.size());
  return problem;
}

template <int Dim>
void AlignmentBranch<Dim>::place(AlignedPair placed, const CovarianceColumns<Dim>& covariances) {
  std::vector<FeaturePair> pairs = placed.features;
  std::erase_if(pairs, [&](const FeaturePair& pair) {
    const Eigen::MatrixXd coupling = this->coupling({&pair, 1}, covariances, Eigen::MatrixXd(0, Dim));
    return !covariance_left(pair, coupling, covariances);
  });
  pairs = far_apart<Dim>(pairs, covariances);
  excess_ += excess_of(pairs, covariances);
  for (const FeaturePair& pair : pairs) hold(pair, covariances);
  log_odds_ += placed.matches.front().score;
  placed_.push_back(std::move(placed));
}

/// The squared Mahalanobis distance of the alignment by pairings from its prediction, less its mean: that of the differences of
/// the pairings and, if these determine an alignment, less the part that no rigid motion removes. The result does not depend on
/// which features, each with errors of its own, a branch happens to pair.
template <int Dim>
double AlignmentBranch<Dim>::excess_of(const std::vector<FeaturePair>& pairs, const CovarianceColumns<Dim>& covariances) const {
  if (pairs.empty()) return 0.0;
  const auto at = [](std::size_t k) { return static_cast<Eigen::Index>(k) * Dim; };
  const Eigen::MatrixXd coupling = this->coupling(pairs, covariances, Eigen::MatrixXd(0, at(pairs.size())));
  Eigen::MatrixXd S = -coupling.transpose() * coupling;
  Eigen::VectorXd difference = expected(coupling);
  Eigen::MatrixXd J_place(at(pairs.size()), kPoseDof<Dim>);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto& [one, other] = pairs[k];
    const Point<Dim> arm = covariances.position(other) - covariances.position(pairs.front().other);
    J_place.template middleRows<Dim>(at(k)) << PointMatrix<Dim>::Identity(), J_turned_rotation(arm);
    difference.template segment<Dim>(at(k)) += covariances.position(one) - covariances.position(other);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      S.template block<Dim, Dim>(at(i), at(k)) +=
          covariances.between(pairs[i].one, one) - covariances.between(pairs[i].one, other) -
          covariances.between(pairs[i].other, one) + covariances.between(pairs[i].other, other);
    }
  }
  const auto squared = [](const Eigen::MatrixXd& covariance, const Eigen::VectorXd& d) {
    return d.dot(covariance.ldlt().solve(d));
  };
  if (pairs.size() < kFewest) return squared(S, difference) - static_cast<double>(at(pairs.size()));
  const Eigen::MatrixXd Q = J_place.householderQr().householderQ();
  const Eigen::MatrixXd shape = Q.rightCols(at(pairs.size()) - kPoseDof<Dim>).transpose();
  return squared(S, difference) - squared(shape * S * shape.transpose(), shape * difference) - kPoseDof<Dim>;
}

/// The covariance of the difference of two features, given the held differences; nullopt if these imply already that the two
/// are the same.
template <int Dim>
std::optional<PointMatrix<Dim>> AlignmentBranch<Dim>::covariance_left(const FeaturePair& pair, const Eigen::MatrixXd& coupling,
                                                                      const CovarianceColumns<Dim>& covariances) const {
  constexpr double kRounding = 1e-6;  // share of a variance
  const PointMatrix<Dim> C = covariances.between(pair.one, pair.other);
  const PointMatrix<Dim> prior =
      covariances.between(pair.one, pair.one) + covariances.between(pair.other, pair.other) - C - C.transpose();
  const PointMatrix<Dim> left = prior - coupling.transpose() * coupling;
  return left.trace() < kRounding * prior.trace() ? std::nullopt : std::optional(left);
}

template <int Dim>
void AlignmentBranch<Dim>::hold(const FeaturePair& pair, const CovarianceColumns<Dim>& covariances) {
  const Eigen::MatrixXd coupling = this->coupling({&pair, 1}, covariances, Eigen::MatrixXd(0, Dim));
  const auto left = covariance_left(pair, coupling, covariances);
  if (!left) return;
  const Eigen::LLT<PointMatrix<Dim>> factor(*left);
  if (factor.info() != Eigen::Success) return;
  const Point<Dim> difference = covariances.position(pair.one) - covariances.position(pair.other) + expected(coupling);
  const Eigen::Index rows = whitened_.size();
  factor_.conservativeResize(rows + Dim, rows + Dim);
  factor_.rightCols(Dim).setZero();
  factor_.bottomLeftCorner(Dim, rows) = coupling.transpose();
  factor_.template bottomRightCorner<Dim, Dim>() = factor.matrixL();
  whitened_.conservativeResize(rows + Dim);
  whitened_.template tail<Dim>() = factor.matrixL().solve(difference);
  held_.push_back(pair);
}

template class CovarianceColumns<2>;
template class CovarianceColumns<3>;
template class AlignmentBranch<2>;
template class AlignmentBranch<3>;

}  // namespace mapjoin
