// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <mapjoin/join/association/matching/beam_search.hpp>
#include <mapjoin/join/association/matching/matching.hpp>
#include <mapjoin/join/association/matching/point_tree.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The most placements compared.
constexpr std::size_t kMostPlacements = 8;
/// Points count as coincident under a shift if they are within this quantile of their distance.
constexpr double kSamePoint = 0.99;

/// All shifts of points onto each other: from the first point to each one, from the next one, …
template <int Dim>
std::vector<Point<Dim>> shifts_between(const std::vector<Point<Dim>>& points) {
  std::vector<Point<Dim>> shifts;
  for (const auto& from : points) {
    for (const auto& to : points) shifts.push_back(to - from);
  }
  return shifts;
}

/// The distance of the nearest of some points (m); infinite if there are none.
template <int Dim>
double distance_of_nearest(const Point<Dim>& from, const std::vector<Point<Dim>>& points) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& point : points) least = std::min(least, (point - from).norm());
  return least;
}

/// The difference of the pairing whose place in its map, as `place_of` gives it, is nearest to a point (m).
template <int Dim, typename PlaceOf>
Point<Dim> nearest_difference(const Point<Dim>& point, const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement,
                              const PlaceOf& place_of) {
  const auto distance = [&](const Pairing& pairing) { return (place_of(pairing) - point).squaredNorm(); };
  return problem.difference(*std::ranges::min_element(placement.pairings(), {}, distance));
}

/// The logarithm of the chance that, where a placement lays two maps on each other, each overlooked all features of the other
/// for which it has none that fits; 0 if the chance of a sighting is not known, or nothing is paired.
template <int Dim>
double log_overlooked(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement,
                      const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates) {
  if (!problem.map_sees || placement.pairings().empty()) return 0.0;
  const KnownAndSightings alone = placement.without_partner(density, gates);
  const auto place_of_known = [&](const Pairing& pairing) { return problem.known[pairing.known]; };
  const auto place_of_sighting = [&](const Pairing& pairing) { return problem.sightings[pairing.sighting]; };
  double sum = 0.0;
  const auto add = [&](const Point<Dim>& point, const MatchedMap<Dim>& by) {
    sum += problem.map_sees->log_overlooked(distance_of_nearest<Dim>(point, by.all), 0.0);
  };
  const auto add_known = [&](const Point<Dim>& p) {
    add(p - nearest_difference<Dim>(p, problem, placement, place_of_known), problem.maps[1]);
  };
  const auto add_sighting = [&](const Point<Dim>& p) {
    add(p + nearest_difference<Dim>(p, problem, placement, place_of_sighting), problem.maps[0]);
  };
  std::ranges::for_each(problem.maps[0].unpaired, add_known);
  for (const std::size_t k : alone.known) add_known(problem.known[k]);
  std::ranges::for_each(problem.maps[1].unpaired, add_sighting);
  for (const std::size_t s : alone.sightings) add_sighting(problem.sightings[s]);
  return sum;
}

}  // namespace

template <int Dim>
Matcher<Dim>::Matcher(const NeighbourDensity<Dim>& density, AssociationMethod method, double confidence, double decisions)
    : density_(density),
      method_(method),
      gates_((1.0 - confidence) / (method == AssociationMethod::kNearest ? 1.0 : std::max(1.0, decisions))) {}

/// Removes choices that are outside of the gates by themselves from the problem. Returns the sightings left with any, those
/// with the fewest and most certain ones first.
template <int Dim>
std::vector<std::size_t> Matcher<Dim>::gated(PairingProblem<Dim>& problem) {
  std::vector<std::pair<std::size_t, double>> rank(problem.sightings.size());
  std::vector<std::size_t> order;
  const Hypothesis<Dim> none(problem);
  for (std::size_t s = 0; s < problem.sightings.size(); ++s) {
    double least = std::numeric_limits<double>::infinity();
    std::erase_if(problem.choices[s], [&](std::size_t known) {
      const auto alone = none.extension({known, s}, density_, gates_);
      if (alone) least = std::min(least, alone->covariance.determinant());
      return !alone;
    });
    rank[s] = {problem.choices[s].size(), least};
    if (!problem.choices[s].empty()) order.push_back(s);
  }
  std::ranges::stable_sort(order, {}, [&](std::size_t s) { return rank[s]; });
  return order;
}

/// The squared Mahalanobis distance of a pairing, which must be within the gates by itself.
template <int Dim>
double Matcher<Dim>::squared_distance(const PairingProblem<Dim>& problem, const Pairing& pairing) {
  return Hypothesis<Dim>(problem).extension(pairing, density_, gates_)->squared_distance();
}

/// The best hypothesis, then the best ones that share no pairing with those before them and have at least half as many pairings
/// as the first, each extended by the pairings of the first that are compatible with it.
template <int Dim>
std::vector<Hypothesis<Dim>> Matcher<Dim>::placements(const PairingProblem<Dim>& problem,
                                                      const std::vector<std::size_t>& order) {
  std::vector<Hypothesis<Dim>> found;
  ForbiddenPairings forbidden(problem.sightings.size());
  while (found.size() < kMostPlacements) {
    Hypothesis<Dim> next = best_hypothesis<Dim>(problem, order, forbidden, density_, gates_);
    const std::size_t pairings = next.pairings().size();
    if (pairings == 0 || (!found.empty() && 2 * pairings < found.front().pairings().size())) break;
    for (const Pairing& p : next.pairings()) forbidden[p.sighting].push_back(p.known);
    if (!found.empty()) next.extend_by(found.front().pairings(), density_, gates_);
    found.push_back(std::move(next));
  }
  return found;
}

template <int Dim>
std::vector<Hypothesis<Dim>> Matcher<Dim>::placements(PairingProblem<Dim>& problem) {
  const std::vector<std::size_t> order = gated(problem);
  return placements(problem, order);
}

template <int Dim>
double Matcher<Dim>::log_odds(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement) {
  return placement.score() + log_overlooked(problem, placement, density_, gates_);
}

template <int Dim>
std::vector<Match> Matcher<Dim>::matches(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement) {
  const std::vector<std::optional<GivenOthers<Dim>>> given_others = placement.given_others(density_, gates_);
  double spread = 0.0;  // largest variance of a pairing along an axis, given the others (m²)
  for (const auto& given : given_others) {
    if (given) spread = std::max(spread, given->covariance.trace() / Dim);
  }
  const double shifts = odds_of_shifts(problem, placement, spread * chi_squared_quantile(kSamePoint, Dim));
  const double log_odds = this->log_odds(problem, placement);
  std::vector<Match> matches;
  for (const Pairing& pairing : placement.pairings()) {
    const auto& given = given_others[matches.size()];
    matches.push_back({pairing.known, given ? probability_of(given->gain) : 0.0, squared_distance(problem, pairing),
                       problem.choices[pairing.sighting].size(), log_odds, 1.0 / (1.0 + shifts)});
  }
  return matches;
}

template <int Dim>
bool Matcher<Dim>::contradicts(const Hypothesis<Dim>& other, const Pairing& pairing) {
  const auto known = other.known_of(pairing.sighting);
  if (known) return known != pairing.known;
  return other.takes(pairing.known) || !other.extension(pairing, density_, gates_);
}

/// The summed odds, against no shift, of all shifts under which at least half of the sightings' map falls onto itself. Odds too
/// small to change a sum with 1 are left out.
template <int Dim>
double Matcher<Dim>::odds_of_shifts(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement,
                                    double tolerance2) const {
  const auto& points = problem.maps[1].all;
  const std::vector<Point<Dim>> shifts = shifts_between<Dim>(points);
  const ShiftGrowth<Dim> growth = placement.growth();
  const auto odds_of = [&](const Point<Dim>& shift) { return std::exp(-0.5 * growth(shift)); };
  std::vector<Point<Dim>> likely;
  std::ranges::copy_if(shifts, std::back_inserter(likely), [&](const Point<Dim>& shift) {
    return shift.squaredNorm() >= tolerance2 && odds_of(shift) >= std::numeric_limits<double>::epsilon();
  });
  if (likely.empty()) return 0.0;
  const PointTree<Dim> point_tree(points);
  const PointTree<Dim> shift_tree(shifts);
  const double tolerance = std::sqrt(tolerance2);
  const std::size_t half = (points.size() + 1) / 2;
  const auto falls_onto_one = [&](const Point<Dim>& p) { return !point_tree.some_within(p, tolerance, 1).empty(); };
  std::vector<Point<Dim>> found;
  double odds = 0.0;
  for (const Point<Dim>& shift : likely) {
    const auto is_near = [&](const Point<Dim>& other) { return (other - shift).squaredNorm() < tolerance2; };
    if (std::ranges::any_of(found, is_near)) continue;
    if (shift_tree.some_within(shift, tolerance, half).size() < half)
      continue;  // there is one for each point that falls onto one
    const auto falling = std::ranges::count_if(points, [&](const Point<Dim>& p) { return falls_onto_one(p + shift); });
    if (static_cast<std::size_t>(falling) < half) continue;
    found.push_back(shift);
    odds += odds_of(shift);
  }
  return odds;
}

template <int Dim>
void Matcher<Dim>::match_jointly(const PairingProblem<Dim>& problem, const std::vector<std::size_t>& order,
                                 std::vector<Match>& matches) {
  const std::vector<Hypothesis<Dim>> found = placements(problem, order);
  if (found.empty()) return;
  const Hypothesis<Dim>& best = found.front();
  const std::vector<Match> of_best = this->matches(problem, best);
  const double log_odds = of_best.front().score;
  const double not_by_chance = probability_of(log_odds - problem.log_tests);
  std::vector<double> odds_of_others;  // by placement after the best
  for (auto other = found.begin() + 1; other != found.end(); ++other) {
    const double by_fit = 0.5 * (best.excess() - other->excess());
    odds_of_others.push_back(std::exp(std::max(by_fit, this->log_odds(problem, *other) - log_odds)));
  }
  for (std::size_t k = 0; k < of_best.size(); ++k) {
    const Pairing& pairing = best.pairings()[k];
    double others = 0.0;
    for (std::size_t other = 1; other < found.size(); ++other) {
      if (contradicts(found[other], pairing)) others += odds_of_others[other - 1];
    }
    Match& match = matches[pairing.sighting];
    match = of_best[k];
    match.placement_probability = 1.0 / (1.0 / match.placement_probability + others);
    match.probability *= match.placement_probability * not_by_chance;
  }
}

template <int Dim>
void Matcher<Dim>::match_nearest(const PairingProblem<Dim>& problem, std::vector<Match>& matches) {
  std::vector<std::pair<double, Pairing>> pairs;  // with their squared distances
  for (std::size_t s = 0; s < matches.size(); ++s) {
    for (const std::size_t known : problem.choices[s])
      pairs.emplace_back(squared_distance(problem, {known, s}), Pairing{known, s});
  }
  std::ranges::stable_sort(pairs, {}, [](const auto& pair) { return pair.first; });
  std::vector<bool> is_taken(problem.known.size(), false);
  for (const auto& [squared_distance, pairing] : pairs) {
    if (is_taken[pairing.known] || matches[pairing.sighting].known) continue;
    is_taken[pairing.known] = true;
    matches[pairing.sighting].known = pairing.known;
    matches[pairing.sighting].probability = matches[pairing.sighting].placement_probability = 1.0;
  }
}

template <int Dim>
std::vector<Match> Matcher<Dim>::operator()(PairingProblem<Dim> problem) {
  std::vector<Match> matches(problem.sightings.size());
  const std::vector<std::size_t> order = gated(problem);
  if (method_ == AssociationMethod::kNearest) {
    match_nearest(problem, matches);
  } else {
    match_jointly(problem, order, matches);
  }
  for (std::size_t s = 0; s < matches.size(); ++s) {
    matches[s].candidates = problem.choices[s].size();
    if (matches[s].known) matches[s].squared_distance = squared_distance(problem, {*matches[s].known, s});
  }
  return matches;
}

template class Matcher<2>;
template class Matcher<3>;

}  // namespace mapjoin
