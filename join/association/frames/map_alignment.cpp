// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/association/frames/alignment_candidates.hpp>
#include <mapjoin/join/association/frames/map_alignment.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <numbers>
#include <optional>
#include <set>

namespace mapjoin {
namespace {

/// The most constellations that are looked at, and the number of features that are looked at around each.
constexpr std::size_t kMostConstellations = 20000;
constexpr std::size_t kGlance = 24;
/// The most candidates whose pairings are extended.
constexpr std::size_t kMostPlaces = 32;

/// A rough score of the alignment by a constellation, and the pairings that it rests on.
struct Glance {
  double score = 0.0;
  std::vector<Pairing> pairs;
  const Constellation* constellation = nullptr;
};

template <int Dim>
class Aligner {
 public:
  Aligner(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second, const AlignmentModel<Dim>& model)
      : first_(first),
        second_(second),
        model_(model),
        places_(first, second, model),
        gate_(chi_squared_quantile(model.confidence, Dim)) {}

  MapAlignment align() const {
    const std::vector<AlignmentCandidate<Dim>> candidates =
        grown(promising(constellations_alike(first_, second_, model_.confidence)));
    if (candidates.empty()) return {};
    const AlignmentCandidate<Dim>& best = candidates.front();
    MapAlignment alignment{AlignmentStatus::kNone, best.pairs, best.score};
    for (auto other = candidates.begin() + 1; other != candidates.end() && is_unique(alignment); ++other) {
      if (places_.agree(best, *other)) {
        unite(alignment.pairs, other->pairs);
      } else if (alignment.other_pairs == 0) {
        alignment.other_score = other->score;
        alignment.other_pairs = other->pairs.size();
      }
    }
    const double pairings = static_cast<double>(first_.features.size()) * static_cast<double>(second_.features.size());
    if (best.score - model_.log_tests - std::log(pairings) < model_.log_odds()) return alignment;
    alignment.status = !is_unique(alignment)    ? AlignmentStatus::kAmbiguous
                       : is_repeated(alignment) ? AlignmentStatus::kRepeated
                                                : AlignmentStatus::kFound;
    return alignment;
  }

  /// The score of the best alignment of the map with itself, other than the identity, that pairs most of `features` or pairs
  /// mostly these; 0 if none.
  double repeat_score(const std::set<std::size_t>& features) const {
    auto constellations = constellations_alike(first_, first_, model_.confidence);
    std::erase_if(constellations,
                  [&](const Constellation& c) { return is_identity(c) || !features.contains(c.front().known); });
    for (const AlignmentCandidate<Dim>& candidate : grown(promising(constellations))) {
      const auto count = std::ranges::count_if(candidate.pairs, [&](const Pairing& p) { return features.contains(p.known); });
      const auto fewer = std::min(std::ssize(candidate.pairs), std::ssize(features));
      if (!is_identity(candidate.pairs) && 2 * count > fewer) return std::max(0.0, candidate.score);
    }
    return 0.0;
  }

 private:
  /// True if most features of a map are paired with themselves.
  static bool is_identity(const std::vector<Pairing>& pairs) {
    return 2 * std::ranges::count_if(pairs, [](const Pairing& p) { return p.known == p.sighting; }) > std::ssize(pairs);
  }

  /// True if the paired features repeat elsewhere in the larger map with half the score: they may then do so anywhere.
  bool is_repeated(const MapAlignment& alignment) const {
    const bool is_first = first_.features.size() >= second_.features.size();
    const FeatureMap<Dim>& larger = is_first ? first_ : second_;
    std::set<std::size_t> paired;
    for (const Pairing& p : alignment.pairs) paired.insert(is_first ? p.known : p.sighting);
    return 2.0 * Aligner(larger, larger, model_).repeat_score(paired) >= alignment.score;
  }

  /// True if no candidate that contradicts the best one has half its score.
  static bool is_unique(const MapAlignment& alignment) { return 2.0 * alignment.other_score < alignment.score; }

  /// The constellations of the best candidates by glance(), one for each candidate.
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

  /// Rates how well the features around a constellation fit those of the other map, each by itself.
  Glance glance(const Constellation& constellation) const {
    Glance glance{0.0, {}, &constellation};
    const auto pose = places_.relative_pose(constellation);
    if (!pose) return glance;
    const Pose<Dim> first_in_second = inverse(*pose);
    const Pairing& centre = constellation[0];
    const double own_variance = relative_variance(centre, constellation[1]);
    for (const std::size_t known : places_.first_tree().nearest(first_.features[centre.known], kGlance)) {
      const Point<Dim> there = transform(first_in_second, first_.features[known]);
      const std::size_t sighting = places_.second_tree().nearest(there, 1).front();
      const double variance = (own_variance + relative_variance(centre, {known, sighting})) / Dim;
      if ((second_.features[sighting] - there).squaredNorm() <= gate_ * variance) {
        glance.score += std::max(0.0, log_odds_within(gate_ * variance));
        glance.pairs.push_back({known, sighting});
      } else {
        glance.score += places_.unseen_by_second(there, variance);
      }
    }
    return glance;
  }
  /// The variance (m²) of the difference of the vectors between two pairings in the two maps, which should be zero.
  double relative_variance(const Pairing& a, const Pairing& b) const {
    return first_.relative_covariance(a.known, b.known).trace() + second_.relative_covariance(a.sighting, b.sighting).trace();
  }
  /// The logarithm of the odds against a feature within a squared distance by chance.
  double log_odds_within(double distance2) const {
    const double volume = Dim == 2 ? std::numbers::pi * distance2 : 4.0 / 3.0 * std::numbers::pi * std::pow(distance2, 1.5);
    return -std::log(std::min(1.0, model_.density.overall() * volume));
  }

  /// The candidates that constellations lead to, the best first.
  std::vector<AlignmentCandidate<Dim>> grown(const std::vector<Constellation>& seeds) const {
    std::vector<std::optional<AlignmentCandidate<Dim>>> found(seeds.size());
    parallel_for(seeds.size(), [&](std::size_t k) { found[k] = places_.grown_from(seeds[k]); });
    std::vector<AlignmentCandidate<Dim>> candidates;
    for (auto& candidate : found) {
      if (candidate) candidates.push_back(*std::move(candidate));
    }
    std::ranges::stable_sort(candidates, std::greater<>(), &AlignmentCandidate<Dim>::score);
    return candidates;
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
  AlignmentCandidates<Dim> places_;
  double gate_;
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
