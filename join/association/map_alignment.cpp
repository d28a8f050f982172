// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/association/map_alignment.hpp>
#include <mapjoin/join/association/point_tree.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>

namespace mapjoin {
namespace {

/// Constellations that are looked at, and neighbours that are looked at around each.
constexpr std::size_t kMostConstellations = 20000;
constexpr std::size_t kGlance = 24;
/// Places that pairings are extended at, and features of either map around each.
constexpr std::size_t kMostPlaces = 32;
constexpr std::size_t kRegion = 60;
/// Features that a sighting may be of, the nearest ones.
constexpr std::size_t kChoices = 4;

/// Pairings that are compatible together, around one feature.
template <int Dim>
struct Place {
  std::vector<Pairing> pairs;
  Pose<Dim> second_in_first;
  double score = 0.0;
};

/// The rotation's part of how a point moves with the frame that it is in, turned about a centre.
Point<2> turned(const Point<2>& arm) {
  return {-arm[1], arm[0]};
}
Matrix<3> turned(const Point<3>& arm) {
  Matrix<3> J;
  J << 0.0, arm[2], -arm[1], -arm[2], 0.0, arm[0], arm[1], -arm[0], 0.0;
  return J;
}

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

template <int Dim>
class Aligner {
 public:
  Aligner(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second, const AlignmentModel<Dim>& model)
      : first_(first),
        second_(second),
        model_(model),
        first_tree_(first.features),
        second_tree_(second.features),
        first_poses_(first.poses),
        second_poses_(second.poses),
        gate_(chi_squared_quantile(model.confidence, Dim)),
        offset_variance_(spread<Dim>(first.features) + spread<Dim>(second.features)) {}

  MapAlignment align() const {
    std::vector<Place<Dim>> places = grown(promising(constellations_alike(first_, second_, model_.confidence)));
    std::ranges::stable_sort(places, std::greater<>(), &Place<Dim>::score);
    if (places.empty()) return {};
    const Place<Dim>& best = places.front();
    MapAlignment alignment{AlignmentStatus::kNone, best.pairs, best.score};
    const double odds = model_.confidence / (1.0 - model_.confidence);
    for (auto other = places.begin() + 1; other != places.end() && is_unique(alignment); ++other) {
      if (agree(best, *other)) {
        unite(alignment.pairs, other->pairs);
      } else if (alignment.other_pairs == 0) {
        alignment.other_score = other->score;
        alignment.other_pairs = other->pairs.size();
      }
    }
    if (best.score - model_.log_tests < std::log(odds)) return alignment;
    alignment.status = is_unique(alignment) ? AlignmentStatus::kFound : AlignmentStatus::kAmbiguous;
    return alignment;
  }

 private:
  /// Whether no place that contradicts it has half its score.
  static bool is_unique(const MapAlignment& alignment) { return 2.0 * alignment.other_score < alignment.score; }

  std::optional<Pose<Dim>> relative_pose(const std::vector<Pairing>& pairs) const {
    std::vector<Point<Dim>> from, to;
    for (const Pairing& p : pairs) {
      from.push_back(second_.features[p.sighting]);
      to.push_back(first_.features[p.known]);
    }
    return rigid_alignment<Dim>(from, to);
  }

  /// What not seeing a feature there says against a place; it may be farther from the poses by what is not known of where it is.
  double missed(const Point<Dim>& feature, double variance, const FeatureMap<Dim>& map, const PointTree<Dim>& poses) const {
    const auto nearest = poses.nearest(feature, 1);
    if (nearest.empty()) return 0.0;
    return std::log(1.0 - model_.sees((map.poses[nearest.front()] - feature).norm() + std::sqrt(gate_ * variance)));
  }

  /// A rough score of the place of a constellation, and the pairings that it is by.
  struct Glance {
    double score = 0.0;
    std::vector<Pairing> pairs;
    const Constellation* constellation = nullptr;
  };
  Glance glance(const Constellation& constellation) const {
    Glance glance{0.0, {}, &constellation};
    const auto pose = relative_pose(constellation);
    if (!pose) return glance;
    const Pose<Dim> first_in_second = inverse(*pose);
    const Pairing& centre = constellation[0];
    const double own_variance = relative_variance(centre, constellation[1]);
    for (const std::size_t known : first_tree_.nearest(first_.features[centre.known], kGlance)) {
      const Point<Dim> there = transform(first_in_second, first_.features[known]);
      const std::size_t sighting = second_tree_.nearest(there, 1).front();
      const double tolerance2 = gate_ / Dim * (own_variance + relative_variance(centre, {known, sighting}));
      if ((second_.features[sighting] - there).squaredNorm() <= tolerance2) {
        glance.score += std::max(0.0, log_odds_within(tolerance2));
        glance.pairs.push_back({known, sighting});
      } else {
        glance.score += missed(there, tolerance2 / gate_, second_, second_poses_);
      }
    }
    return glance;
  }
  /// Of the difference that two pairings should have none of.
  double relative_variance(const Pairing& a, const Pairing& b) const {
    return first_.relative_covariance(a.known, b.known).trace() + second_.relative_covariance(a.sighting, b.sighting).trace();
  }
  /// The logarithm of the odds against a feature within a tolerance by chance.
  double log_odds_within(double tolerance2) const {
    const double volume = Dim == 2 ? std::numbers::pi * tolerance2 : 4.0 / 3.0 * std::numbers::pi * std::pow(tolerance2, 1.5);
    return -std::log(std::min(1.0, model_.density.overall() * volume));
  }

  /// The constellations of the best places by glance, of each place one.
  std::vector<Constellation> promising(const std::vector<Constellation>& all) const {
    std::vector<const Constellation*> largest;
    for (const Constellation& c : all) largest.push_back(&c);
    std::ranges::stable_sort(largest, std::greater<>(), [](const Constellation* c) { return c->size(); });
    largest.resize(std::min(largest.size(), kMostConstellations));
    std::vector<Glance> glances(largest.size());
    parallel_for(largest.size(), [&](std::size_t k) { glances[k] = glance(*largest[k]); });
    std::ranges::stable_sort(glances, std::greater<>(), &Glance::score);
    std::vector<Constellation> chosen;
    std::set<std::pair<std::size_t, std::size_t>> known;
    for (const Glance& g : glances) {
      if (chosen.size() == kMostPlaces || g.score <= 0.0) break;
      const Pairing& centre = g.constellation->front();
      if (known.contains({centre.known, centre.sighting})) continue;
      chosen.push_back(*g.constellation);
      for (const Pairing& p : g.pairs) known.emplace(p.known, p.sighting);
    }
    return chosen;
  }

  std::vector<Place<Dim>> grown(const std::vector<Constellation>& seeds) const {
    std::vector<std::optional<Place<Dim>>> found(seeds.size());
    parallel_for(seeds.size(), [&](std::size_t k) { found[k] = grown(seeds[k]); });
    std::vector<Place<Dim>> places;
    for (auto& place : found) {
      if (place) places.push_back(*std::move(place));
    }
    return places;
  }

  /// Features of both maps under a relative pose that may be anything, linearised at one.
  PairingProblem<Dim> problem(const std::vector<std::size_t>& known, const std::vector<std::size_t>& sightings,
                              const Pose<Dim>& pose) const {
    PairingProblem<Dim> problem;
    const auto row = [](std::size_t k) { return static_cast<Eigen::Index>(k) * Dim; };
    for (const std::size_t k : known) problem.known.push_back(first_.features[k]);
    for (const std::size_t s : sightings) problem.sightings.push_back(transform(pose, second_.features[s]));
    const Eigen::Index begin = row(known.size());
    const Eigen::Index end = begin + row(sightings.size());
    problem.covariance.setZero(end, end);
    for (std::size_t i = 0; i < known.size(); ++i) {
      for (std::size_t k = 0; k < known.size(); ++k) {
        problem.covariance.template block<Dim, Dim>(row(i), row(k)) = first_.covariance_of(known[i], known[k]);
      }
    }
    constexpr int kRot = kRotationDof<Dim>;
    const PointMatrix<Dim> R = pose.rotation.matrix();
    const double turn_variance = std::numbers::pi * std::numbers::pi / 3.0;
    const Point<Dim> centre = problem.sightings.front();
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      const Eigen::Matrix<double, Dim, kRot> J_i = turned(Point<Dim>(problem.sightings[i] - centre));
      for (std::size_t k = 0; k < sightings.size(); ++k) {
        const Eigen::Matrix<double, Dim, kRot> J_k = turned(Point<Dim>(problem.sightings[k] - centre));
        problem.covariance.template block<Dim, Dim>(begin + row(i), begin + row(k)) =
            R * second_.covariance_of(sightings[i], sightings[k]) * R.transpose() +
            offset_variance_ * PointMatrix<Dim>::Identity() + turn_variance * J_i * J_k.transpose();
      }
    }
    return problem;
  }

  /// Pairings as the problem over some features counts them; what it does not have is passed over.
  static std::vector<Pairing> within(const std::vector<Pairing>& pairs, const std::vector<std::size_t>& known,
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

  std::optional<Place<Dim>> grown(const Constellation& seed) const {
    const auto pose = relative_pose(seed);
    if (!pose) return std::nullopt;
    const Pairing centre = seed.front();
    const auto known = first_tree_.nearest(first_.features[centre.known], kRegion);
    const auto sightings = second_tree_.nearest(second_.features[centre.sighting], kRegion);
    const PairingProblem<Dim> problem = this->problem(known, sightings, *pose);
    ChiSquaredQuantiles gates(1.0 - (1.0 - model_.confidence) / static_cast<double>(known.size()));
    Hypothesis<Dim> hypothesis(problem);
    double prior = 0.0;
    for (const Pairing& pairing : within(seed, known, sightings)) {
      if (const auto extension = hypothesis.extension(pairing, model_.density, gates)) {
        if (hypothesis.pairings().size() < Dim) prior += anywhere(*extension);
        hypothesis.extend(*extension);
      }
    }
    if (hypothesis.pairings().size() < Dim) return std::nullopt;
    for (std::size_t s = 0; s < sightings.size(); ++s) {
      if (!hypothesis.known_of(s)) extend(problem, s, hypothesis, gates);
    }
    Place<Dim> place{{}, *pose, hypothesis.score() + prior};
    for (const Pairing& p : hypothesis.pairings()) place.pairs.push_back({known[p.known], sightings[p.sighting]});
    if (const auto refined = relative_pose(place.pairs)) place.second_in_first = *refined;
    place.score += against(problem, known, sightings, hypothesis, place.second_in_first, gates);
    return place;
  }

  /// What corrects the gain of a pairing for which the relative pose is open: it has the density of the whole map against it, not
  /// that of what is seen at once.
  double anywhere(const Extension<Dim>& extension) const {
    const Point<Dim> difference = extension.covariance.llt().matrixL() * extension.whitened;
    const double apart = std::sqrt(difference.squaredNorm() + extension.covariance.trace());
    return model_.density.log_within(apart) - std::log(model_.density.overall());
  }

  /// Where a sighting is by its nearest neighbour that is paired.
  static Point<Dim> expected(const PairingProblem<Dim>& problem, std::size_t sighting, const Hypothesis<Dim>& hypothesis) {
    const Point<Dim>& there = problem.sightings[sighting];
    const auto nearest = std::ranges::min_element(hypothesis.pairings(), {}, [&](const Pairing& p) {
      return (problem.sightings[p.sighting] - there).squaredNorm();
    });
    return there + problem.difference(*nearest);
  }
  static std::vector<std::size_t> nearest_known(const PairingProblem<Dim>& problem, const Point<Dim>& there) {
    std::vector<std::size_t> known(problem.known.size());
    std::iota(known.begin(), known.end(), std::size_t{0});
    const auto most = known.begin() + static_cast<std::ptrdiff_t>(std::min(kChoices, known.size()));
    std::ranges::partial_sort(known, most, {}, [&](std::size_t k) { return (problem.known[k] - there).squaredNorm(); });
    known.erase(most, known.end());
    return known;
  }

  /// By the pairing of a sighting that gains most, unless another one gains nearly as much.
  void extend(const PairingProblem<Dim>& problem, std::size_t sighting, Hypothesis<Dim>& hypothesis,
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
      if (best) second = std::max(second, best->gain);
      best = std::move(extension);
    }
    const double odds = model_.confidence / (1.0 - model_.confidence);
    if (best && best->gain > std::max(0.0, second + std::log(odds))) hypothesis.extend(*best);
  }

  /// What speaks against a place: features of one map that the other should have seen there, and did not.
  double against(const PairingProblem<Dim>& problem, const std::vector<std::size_t>& known,
                 const std::vector<std::size_t>& sightings, const Hypothesis<Dim>& hypothesis, const Pose<Dim>& pose,
                 ChiSquaredQuantiles& gates) const {
    const auto reach = [](const std::vector<Point<Dim>>& points, std::size_t of_all) {
      return points.size() < of_all ? (points.back() - points.front()).norm() : std::numeric_limits<double>::infinity();
    };
    const double radius =
        std::min(reach(problem.known, first_.features.size()), reach(problem.sightings, second_.features.size()));
    std::vector<bool> has_partner(known.size(), false);
    double sum = 0.0;
    for (std::size_t s = 0; s < sightings.size(); ++s) {
      bool is_explained = hypothesis.known_of(s).has_value();
      for (const std::size_t k : nearest_known(problem, expected(problem, s, hypothesis))) {
        if (hypothesis.known_of(s) == k || (!hypothesis.known_of(s) && hypothesis.extension({k, s}, model_.density, gates))) {
          is_explained = has_partner[k] = true;
        }
      }
      if (is_explained || (problem.sightings[s] - problem.sightings.front()).norm() > radius) continue;
      const double variance = 2.0 * second_.relative_covariance(sightings.front(), sightings[s]).trace();
      sum += missed(transform(pose, second_.features[sightings[s]]), variance, first_, first_poses_);
    }
    const Pose<Dim> first_in_second = inverse(pose);
    for (std::size_t k = 0; k < known.size(); ++k) {
      if (has_partner[k] || hypothesis.takes(k) || (problem.known[k] - problem.known.front()).norm() > radius) continue;
      const double variance = 2.0 * first_.relative_covariance(known.front(), known[k]).trace();
      sum += missed(transform(first_in_second, problem.known[k]), variance, second_, second_poses_);
    }
    return sum;
  }

  /// Whether most pairings of another place are compatible with those of the best one.
  bool agree(const Place<Dim>& best, const Place<Dim>& other) const {
    std::vector<std::size_t> known, sightings;
    for (const auto* place : {&best, &other}) {
      for (const Pairing& p : place->pairs) {
        known.push_back(p.known);
        sightings.push_back(p.sighting);
      }
    }
    for (auto* list : {&known, &sightings}) {
      std::ranges::sort(*list);
      list->erase(std::ranges::unique(*list).begin(), list->end());
    }
    const PairingProblem<Dim> problem = this->problem(known, sightings, best.second_in_first);
    ChiSquaredQuantiles gates(1.0 - (1.0 - model_.confidence) / static_cast<double>(known.size()));
    Hypothesis<Dim> hypothesis(problem);
    hypothesis.extend_by(within(best.pairs, known, sightings), model_.density, gates);
    const auto others = within(other.pairs, known, sightings);
    hypothesis.extend_by(others, model_.density, gates);
    const auto is_in = [&](const Pairing& p) { return hypothesis.known_of(p.sighting) == p.known; };
    return 2 * std::ranges::count_if(others, is_in) >= std::ssize(others);
  }

  static void unite(std::vector<Pairing>& pairs, const std::vector<Pairing>& more) {
    for (const Pairing& p : more) {
      const auto clashes = [&](const Pairing& q) { return p.known == q.known || p.sighting == q.sighting; };
      if (std::ranges::none_of(pairs, clashes)) pairs.push_back(p);
    }
  }

  const FeatureMap<Dim>& first_;
  const FeatureMap<Dim>& second_;
  const AlignmentModel<Dim>& model_;
  PointTree<Dim> first_tree_;
  PointTree<Dim> second_tree_;
  PointTree<Dim> first_poses_;
  PointTree<Dim> second_poses_;
  double gate_;
  double offset_variance_;  // along an axis, of where the second map may lie (m²)
};

}  // namespace

template <int Dim>
MapAlignment align_maps(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second, const AlignmentModel<Dim>& model) {
  if (first.features.empty() || second.features.empty()) return {};
  return Aligner<Dim>(first, second, model).align();
}

template MapAlignment align_maps(const FeatureMap<2>&, const FeatureMap<2>&, const AlignmentModel<2>&);
template MapAlignment align_maps(const FeatureMap<3>&, const FeatureMap<3>&, const AlignmentModel<3>&);

}  // namespace mapjoin
