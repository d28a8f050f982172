// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/association/frames/alignment_candidates.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/lists.hpp>
#include <numbers>
#include <numeric>

namespace mapjoin {
namespace {

/// Number of features of either map around a constellation.
constexpr std::size_t kRegion = 60;
/// Number of features that a sighting may be of, the nearest ones.
constexpr std::size_t kChoices = 4;

/// The mean variance of points along an axis.
template <int Dim>
double spread(const std::vector<Point<Dim>>& points) {
  Point<Dim> mean = Point<Dim>::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  double sum = 0.0;
  for (const auto& p : points) sum += (p - mean).squaredNorm();
  return sum / static_cast<double>(points.size()) / Dim;
}

/// The pairings by their indices in `known` and `sightings`; those not in both are left out.
std::vector<Pairing> within(const std::vector<Pairing>& pairs, const std::vector<std::size_t>& known,
                            const std::vector<std::size_t>& sightings) {
  std::vector<Pairing> found;
  for (const Pairing& p : pairs) {
    const auto k = std::ranges::find(known, p.known);
    const auto s = std::ranges::find(sightings, p.sighting);
    if (k == known.end() || s == sightings.end()) continue;
    found.push_back({static_cast<std::size_t>(k - known.begin()), static_cast<std::size_t>(s - sightings.begin())});
  }
  return found;
}

/// The position of a sighting that its nearest paired neighbour implies (m).
template <int Dim>
Point<Dim> expected(const PairingProblem<Dim>& problem, std::size_t sighting, const Hypothesis<Dim>& hypothesis) {
  const Point<Dim>& there = problem.sightings[sighting];
  const auto nearest = std::ranges::min_element(
      hypothesis.pairings(), {}, [&](const Pairing& p) { return (problem.sightings[p.sighting] - there).squaredNorm(); });
  return there + problem.difference(*nearest);
}

template <int Dim>
std::vector<std::size_t> nearest_known(const PairingProblem<Dim>& problem, const Point<Dim>& there) {
  std::vector<std::size_t> known(problem.known.size());
  std::iota(known.begin(), known.end(), std::size_t{0});
  const auto most = known.begin() + static_cast<std::ptrdiff_t>(std::min(kChoices, known.size()));
  std::ranges::partial_sort(known, most, {}, [&](std::size_t k) { return (problem.known[k] - there).squaredNorm(); });
  known.erase(most, known.end());
  return known;
}

}  // namespace

template <int Dim>
AlignmentCandidates<Dim>::AlignmentCandidates(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second,
                                              const AlignmentModel<Dim>& model)
    : first_(first),
      second_(second),
      model_(model),
      first_tree_(first.features),
      second_tree_(second.features),
      first_poses_(first.poses),
      second_poses_(second.poses),
      gate_(chi_squared_quantile(model.confidence, Dim)),
      offset_variance_(spread<Dim>(first.features) + spread<Dim>(second.features)) {}

template <int Dim>
std::optional<Pose<Dim>> AlignmentCandidates<Dim>::relative_pose(const std::vector<Pairing>& pairs) const {
  std::vector<Point<Dim>> from, to;
  for (const Pairing& p : pairs) {
    from.push_back(second_.features[p.sighting]);
    to.push_back(first_.features[p.known]);
  }
  return rigid_alignment<Dim>(from, to);
}

template <int Dim>
double AlignmentCandidates<Dim>::unseen(const Point<Dim>& feature, double variance, const FeatureMap<Dim>& map,
                                        const PointTree<Dim>& poses) const {
  const auto nearest = poses.nearest(feature, 1);
  if (nearest.empty()) return 0.0;
  return std::log(1.0 - model_.sees((map.poses[nearest.front()] - feature).norm() + std::sqrt(gate_ * variance)));
}

/// The pairing problem of features of both maps under an arbitrary relative pose, linearised at `pose`, whose prior covariance
/// is added to those of the maps.
template <int Dim>
PairingProblem<Dim> AlignmentCandidates<Dim>::problem(const Features& features, const Pose<Dim>& pose) const {
  const auto& [known, sightings] = features;
  PairingProblem<Dim> problem;
  for (const std::size_t k : known) problem.known.push_back(first_.features[k]);
  for (const std::size_t s : sightings) problem.sightings.push_back(transform(pose, second_.features[s]));
  const Eigen::Index end = problem.row_of_sighting(sightings.size());
  problem.covariance.setZero(end, end);
  for (std::size_t i = 0; i < known.size(); ++i) {
    for (std::size_t k = 0; k < known.size(); ++k) {
      problem.covariance.template block<Dim, Dim>(problem.row_of_known(i), problem.row_of_known(k)) =
          first_.covariance_of(known[i], known[k]);
    }
  }
  const PointMatrix<Dim> R = pose.rotation.matrix();
  constexpr double kTurnVariance = std::numbers::pi * std::numbers::pi / 3.0;  // uniform over all angles (rad²)
  const Point<Dim> centre = problem.sightings.front();
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const auto J_i = J_turned_rotation(Point<Dim>(problem.sightings[i] - centre));
    for (std::size_t k = 0; k < sightings.size(); ++k) {
      const auto J_k = J_turned_rotation(Point<Dim>(problem.sightings[k] - centre));
      problem.covariance.template block<Dim, Dim>(problem.row_of_sighting(i), problem.row_of_sighting(k)) =
          R * second_.covariance_of(sightings[i], sightings[k]) * R.transpose() +
          offset_variance_ * PointMatrix<Dim>::Identity() + kTurnVariance * J_i * J_k.transpose();
    }
  }
  return problem;
}

template <int Dim>
std::optional<AlignmentCandidate<Dim>> AlignmentCandidates<Dim>::grown_from(const Constellation& seed) const {
  const auto pose = relative_pose(seed);
  if (!pose) return std::nullopt;
  const Pairing centre = seed.front();
  const Features features{first_tree_.nearest(first_.features[centre.known], kRegion),
                          second_tree_.nearest(second_.features[centre.sighting], kRegion)};
  PairingProblem<Dim> problem = this->problem(features, *pose);
  ChiSquaredQuantiles gates = gates_for(features);
  Hypothesis<Dim> hypothesis(problem);
  double prior = 0.0;
  for (const Pairing& pairing : within(seed, features.known, features.sightings)) {
    if (const auto extension = hypothesis.extension(pairing, model_.density, gates)) {
      if (hypothesis.pairings().size() < Dim) prior += anywhere(*extension);
      hypothesis.extend(*extension);
    }
  }
  if (hypothesis.pairings().size() < Dim) return std::nullopt;
  for (std::size_t s = 0; s < features.sightings.size(); ++s) {
    if (!hypothesis.known_of(s)) extend(problem, s, hypothesis, gates);
  }
  AlignmentCandidate<Dim> candidate{{}, *pose, hypothesis.score() + prior};
  for (const Pairing& p : hypothesis.pairings()) {
    candidate.pairs.push_back({features.known[p.known], features.sightings[p.sighting]});
  }
  if (const auto refined = relative_pose(candidate.pairs)) candidate.second_in_first = *refined;
  for (std::size_t s = 0; s < features.sightings.size(); ++s) {
    problem.choices.push_back(nearest_known(problem, expected(problem, s, hypothesis)));
  }
  candidate.score += against(problem, features, hypothesis, candidate.second_in_first, gates);
  return candidate;
}

/// The correction to the gain of a pairing while the relative pose is open: its odds are against the density of the whole map,
/// not against that near a feature.
template <int Dim>
double AlignmentCandidates<Dim>::anywhere(const Extension<Dim>& extension) const {
  const Point<Dim> difference = extension.covariance.llt().matrixL() * extension.whitened;
  return model_.density.log_within(difference.squaredNorm(), extension.covariance.trace() / Dim) -
         std::log(model_.density.overall());
}

/// Extends the hypothesis by the pairing of a sighting that gains most, unless another one gains nearly as much.
template <int Dim>
void AlignmentCandidates<Dim>::extend(const PairingProblem<Dim>& problem, std::size_t sighting, Hypothesis<Dim>& hypothesis,
                                      ChiSquaredQuantiles& gates) const {
  std::optional<Extension<Dim>> best;
  double second = -std::numeric_limits<double>::infinity();
  for (const std::size_t known : nearest_known(problem, expected(problem, sighting, hypothesis))) {
    if (hypothesis.takes(known)) continue;
    auto extension = hypothesis.extension({known, sighting}, model_.density, gates);
    if (!extension) continue;
    if (best && extension->gain <= best->gain) {
      second = std::max(second, extension->gain);
      continue;
    }
    if (best) second = best->gain;
    best = std::move(extension);
  }
  if (best && best->gain > std::max(0.0, second + model_.log_odds())) hypothesis.extend(*best);
}

/// The log odds, at most 0, that features without partner in the other map, which should have seen them, add to an alignment.
template <int Dim>
double AlignmentCandidates<Dim>::against(const PairingProblem<Dim>& problem, const Features& features,
                                         const Hypothesis<Dim>& hypothesis, const Pose<Dim>& pose,
                                         ChiSquaredQuantiles& gates) const {
  const auto reach = [](const std::vector<Point<Dim>>& points, std::size_t of_all) {
    return points.size() < of_all ? (points.back() - points.front()).norm() : std::numeric_limits<double>::infinity();
  };
  const double radius =
      std::min(reach(problem.known, first_.features.size()), reach(problem.sightings, second_.features.size()));
  const KnownAndSightings alone = hypothesis.without_partner(model_.density, gates);
  double sum = 0.0;
  for (const std::size_t s : alone.sightings) {
    if ((problem.sightings[s] - problem.sightings.front()).norm() > radius) continue;
    const std::size_t feature = features.sightings[s];
    const double variance = 2.0 * second_.relative_covariance(features.sightings.front(), feature).trace();
    sum += unseen_by_first(transform(pose, second_.features[feature]), variance);
  }
  const Pose<Dim> first_in_second = inverse(pose);
  for (const std::size_t k : alone.known) {
    if ((problem.known[k] - problem.known.front()).norm() > radius) continue;
    const double variance = 2.0 * first_.relative_covariance(features.known.front(), features.known[k]).trace();
    sum += unseen_by_second(transform(first_in_second, problem.known[k]), variance);
  }
  return sum;
}

template <int Dim>
bool AlignmentCandidates<Dim>::agree(const AlignmentCandidate<Dim>& best, const AlignmentCandidate<Dim>& other) const {
  Features features;
  for (const auto* candidate : {&best, &other}) {
    for (const Pairing& p : candidate->pairs) {
      features.known.push_back(p.known);
      features.sightings.push_back(p.sighting);
    }
  }
  for (auto* list : {&features.known, &features.sightings}) {
    make_distinct(*list);
  }
  const PairingProblem<Dim> problem = this->problem(features, best.second_in_first);
  ChiSquaredQuantiles gates = gates_for(features);
  Hypothesis<Dim> hypothesis(problem);
  hypothesis.extend_by(within(best.pairs, features.known, features.sightings), model_.density, gates);
  const auto others = within(other.pairs, features.known, features.sightings);
  hypothesis.extend_by(others, model_.density, gates);
  const auto is_in = [&](const Pairing& p) { return hypothesis.known_of(p.sighting) == p.known; };
  return 2 * std::ranges::count_if(others, is_in) >= std::ssize(others);
}

template class AlignmentCandidates<2>;
template class AlignmentCandidates<3>;

}  // namespace mapjoin
