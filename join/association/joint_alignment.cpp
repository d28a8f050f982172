// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <mapjoin/join/association/joint_alignment.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <optional>

namespace mapjoin {
namespace {

/// The most branches that are followed, and the least odds of a branch against the best one.
constexpr std::size_t kMostAlignmentBranches = 64;
constexpr double kLeastOdds = 1e-6;
/// Pairs of maps count as about as sure as the surest one if they are at most this many times as confusable.
constexpr double kAsSure = 2.0;
/// The most pairs of maps considered, the surest ones; the most that are tried; the number of held pairings that ends the
/// search.
constexpr std::size_t kMostPairs = 4000;
constexpr std::size_t kMostTried = 400;
constexpr std::size_t kMostHeld = 300;

/// The number of features that two maps probably share: sightings nearer to a known feature than that one's nearest neighbour.
/// 0 if fewer than kFewest, or than half of the features of the smaller map.
template <int Dim>
std::size_t overlap(const std::vector<Point<Dim>>& known, const std::vector<Point<Dim>>& sightings) {
  const auto nearest = [&](const Point<Dim>& point, std::size_t but) {
    std::pair<double, std::size_t> least{std::numeric_limits<double>::infinity(), known.size()};
    for (std::size_t k = 0; k < known.size(); ++k) {
      if (k != but) least = std::min(least, {(known[k] - point).squaredNorm(), k});
    }
    return least;
  };
  const auto is_among = [&](const Point<Dim>& sighting) {
    const auto [distance, place] = nearest(sighting, known.size());
    return distance < nearest(known[place], place).first;
  };
  const std::size_t fewer = std::min(known.size(), sightings.size());
  if (fewer < AlignmentBranch<Dim>::kFewest) return 0;
  const auto among = static_cast<std::size_t>(std::ranges::count_if(sightings, is_among));
  return among < AlignmentBranch<Dim>::kFewest || 2 * among < fewer ? 0 : std::min(among, fewer);
}

/// The largest value of the branches.
template <typename Branch, typename Value>
double largest(const std::vector<Branch>& branches, const Value& value) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Branch& branch : branches) most = std::max(most, std::invoke(value, branch));
  return most;
}

bool share_a_pairing(const AlignedPair& one, const AlignedPair& other) {
  return std::ranges::any_of(
      one.features, [&](const FeaturePair& p) { return std::ranges::find(other.features, p) != other.features.end(); });
}

}  // namespace

template <int Dim>
JointAlignment<Dim>::JointAlignment(const FeatureEstimate<Dim>& estimate, const Identities& identities,
                                    const NeighbourDensity<Dim>& density, const MapMatching<Dim>& matching, double confidence,
                                    std::vector<MapPair<Dim>> pairs)
    : estimate_(estimate),
      identities_(identities),
      matching_(matching),
      confidence_(confidence),
      per_deviation_(density.confusable_per_deviation()),
      gate_(matching.matcher().gate()),
      pairs_(std::move(pairs)),
      covariances_(estimate),
      branches_(1) {
  std::ranges::stable_sort(pairs_, {}, &MapPair<Dim>::confusable);
  pairs_.resize(std::min(kMostPairs, pairs_.size()));
  is_tried_.resize(pairs_.size());
  coupling_.resize(0, static_cast<Eigen::Index>(pairs_.size()) * Dim);
}

template <int Dim>
typename JointAlignment<Dim>::Features JointAlignment<Dim>::features_of(const MapPair<Dim>& pair) const {
  Features features;
  const auto of_earlier = identities_.features_in(pair.maps[0]);
  const auto of_later = identities_.features_in(pair.maps[1]);
  std::ranges::set_difference(of_earlier, of_later, std::back_inserter(features.known));
  std::ranges::set_difference(of_later, of_earlier, std::back_inserter(features.sightings));
  return features;
}

/// The overlap of a pair of maps if the earlier one's features move by `moved` (m).
template <int Dim>
std::size_t JointAlignment<Dim>::overlap_where(const MapPair<Dim>& pair, const Point<Dim>& moved) const {
  const Features features = features_of(pair);
  std::vector<Point<Dim>> known, sightings;
  for (const FeatureIndex f : features.known) known.push_back(covariances_.position(f) + moved);
  for (const FeatureIndex f : features.sightings) sightings.push_back(covariances_.position(f));
  return overlap<Dim>(known, sightings);
}

/// All pairs of maps not tried yet, given what the best branch holds.
template <int Dim>
std::vector<typename JointAlignment<Dim>::Rated> JointAlignment<Dim>::rated() {
  const Branch& best = branches_.front();
  const auto same = std::ranges::mismatch(held_, best.held()).in1 - held_.begin();
  std::vector<FeaturePair> differences;
  for (const auto& pair : pairs_) differences.push_back(pair.features);
  coupling_ = best.coupling(differences, covariances_, coupling_.topRows(static_cast<Eigen::Index>(same) * Dim));
  held_ = best.held();
  const Eigen::VectorXd expected = best.expected(coupling_);
  std::vector<Rated> rated;
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    if (is_tried_[k]) continue;
    const auto column = static_cast<Eigen::Index>(k) * Dim;
    const auto V = coupling_.middleCols<Dim>(column);
    const PointMatrix<Dim> S = pairs_[k].covariance - V.transpose() * V;
    rated.push_back({k, per_deviation_ * std::sqrt(std::max(0.0, S.determinant())), expected.segment<Dim>(column)});
  }
  return rated;
}

/// The pair of maps to try next: among those that the best branch leaves confusable, the one of the least confusable that
/// overlaps most. If no pair does, but branches disagree, the most confusable of the others that overlap, which tells most
/// about the branches; otherwise nullopt.
template <int Dim>
std::optional<std::size_t> JointAlignment<Dim>::next() {
  std::vector<Rated> all = rated();
  std::ranges::stable_sort(all, {}, &Rated::confusable);
  const auto open = std::ranges::partition_point(all, [&](const Rated& r) { return r.confusable < 1.0 - confidence_; });
  double most = std::numeric_limits<double>::infinity();
  std::pair<std::size_t, std::size_t> best{0, 0};  // the overlap, and the pair
  for (auto r = open; r != all.end() && r->confusable <= most; ++r) {
    const std::size_t overlap = overlap_where(pairs_[r->pair], r->moved);
    if (overlap == 0) continue;
    most = std::min(most, kAsSure * r->confusable);
    if (overlap > best.first || (overlap == best.first && r->pair < best.second)) best = {overlap, r->pair};
  }
  if (best.first > 0) return best.second;
  if (is_sure()) return std::nullopt;
  const auto witness = std::find_if(std::make_reverse_iterator(open), all.rend(),
                                    [&](const Rated& r) { return overlap_where(pairs_[r.pair], r.moved) > 0; });
  return witness == all.rend() ? std::nullopt : std::optional(witness->pair);
}

template <int Dim>
PairingProblem<Dim> JointAlignment<Dim>::problem(const Branch& branch, const Features& features) const {
  PairingProblem<Dim> problem = branch.problem(features.known, features.sightings, covariances_);
  problem.maps[0].all = problem.known;
  problem.maps[1].all = problem.sightings;
  problem.map_sees = &matching_.map_sees();
  for (std::size_t s = 0; s < features.sightings.size(); ++s) {
    for (std::size_t k = 0; k < features.known.size(); ++k) {
      const Pairing pairing{k, s};
      if (!identities_.may_be_same(features.known[k], features.sightings[s])) continue;
      const double bound = gate_ * problem.covariance_of(pairing, pairing).trace();
      if (problem.difference(pairing).squaredNorm() <= bound) problem.choices[s].push_back(k);
    }
  }
  return problem;
}

/// A branch with each possible alignment of a pair of maps; if none, the branch itself, charged if the maps overlap.
template <int Dim>
std::vector<AlignmentBranch<Dim>> JointAlignment<Dim>::placed(const Branch& branch, std::size_t pair,
                                                              const Features& features) const {
  PairingProblem<Dim> problem = this->problem(branch, features);
  Matcher<Dim> matcher = matching_.matcher();
  std::vector<Branch> found;
  for (const Hypothesis<Dim>& placement : matcher.placements(problem)) {
    if (placement.pairings().size() < AlignmentBranch<Dim>::kFewest) continue;
    if (probability_of(placement.score() - matching_.log_pairs()) < confidence_) continue;  // chance may find it
    AlignedPair placed{pair, {}, matcher.matches(problem, placement)};
    for (const Pairing& p : placement.pairings()) {
      placed.features.push_back({features.known[p.known], features.sightings[p.sighting]});
    }
    found.push_back(branch);
    found.back().place(std::move(placed), covariances_);
  }
  if (!found.empty()) return found;
  found.push_back(branch);
  if (overlap<Dim>(problem.known, problem.sightings) > 0) found.back().charge(gate_ - Dim);  // no alignment is within the gate
  return found;
}

/// Aligns a pair of maps in all branches. A pair that the best branch cannot align is left alone: if noise is larger than
/// stated, a misfit says little about which branch is right.
template <int Dim>
void JointAlignment<Dim>::place(std::size_t pair) {
  is_tried_[pair] = true;
  const Features features = features_of(pairs_[pair]);
  covariances_.add(features.known);
  covariances_.add(features.sightings);
  std::vector<std::vector<Branch>> next(branches_.size());
  next.front() = placed(branches_.front(), pair, features);
  if (next.front().front().placed().size() > branches_.front().placed().size()) {
    parallel_for(branches_.size() - 1, [&](std::size_t k) { next[k + 1] = placed(branches_[k + 1], pair, features); });
    std::vector<Branch> all;
    for (auto& some : next) std::ranges::move(some, std::back_inserter(all));
    prune(std::move(all));
  }
  std::vector<FeatureIndex> held;
  for (const Branch& branch : branches_) {
    for (const FeaturePair& p : branch.held()) held.insert(held.end(), {p.one, p.other});
  }
  covariances_.keep(held);
}

template <int Dim>
void JointAlignment<Dim>::prune(std::vector<Branch> branches) {
  std::ranges::stable_sort(branches, {}, &Branch::excess);
  const double least_excess = branches.front().excess();
  const double most_odds = largest(branches, &Branch::log_odds);
  // How far a branch is behind the best one, by fit or by odds, whichever is less.
  const auto behind = [&](const Branch& b) { return std::min(b.excess() - least_excess, 2.0 * (most_odds - b.log_odds())); };
  std::erase_if(branches, [&](const Branch& b) { return behind(b) > -2.0 * std::log(kLeastOdds); });
  std::ranges::stable_sort(branches.begin() + 1, branches.end(), {}, behind);
  branches.resize(std::min(kMostAlignmentBranches, branches.size()));
  branches_ = std::move(branches);
}

/// The share of the branches, weighted by their probabilities, that align a pair of maps alike: with a pairing in common. It is
/// the lesser of two shares: by how well the alignments fit each other, and by the odds of all pairings.
template <int Dim>
double JointAlignment<Dim>::share_of(const AlignedPair& placed) const {
  const auto aligns_alike = [&](const AlignedPair& p) { return p.pair == placed.pair && share_a_pairing(p, placed); };
  const auto share_by = [&](const auto& log_weight) {
    const double most = largest(branches_, log_weight);
    double with = 0.0;
    double all = 0.0;
    for (const Branch& branch : branches_) {
      const double weight = std::exp(log_weight(branch) - most);
      all += weight;
      if (std::ranges::any_of(branch.placed(), aligns_alike)) with += weight;
    }
    return with / all;
  };
  return std::min(share_by([](const Branch& b) { return -0.5 * b.excess(); }),
                  share_by([](const Branch& b) { return b.log_odds(); }));
}

/// True if the share of the branches that agree with the best one on each pair of maps reaches
/// MapMatching::placement_confidence().
template <int Dim>
bool JointAlignment<Dim>::is_sure() const {
  return std::ranges::all_of(branches_.front().placed(),
                             [&](const AlignedPair& p) { return share_of(p) >= matching_.placement_confidence(); });
}

template <int Dim>
std::vector<Proposal> JointAlignment<Dim>::propose(const std::stop_token& stop) {
  for (std::size_t tried = 0; tried < kMostTried && branches_.front().held().size() < kMostHeld; ++tried) {
    const auto pair = stop.stop_requested() ? std::nullopt : next();
    if (!pair) break;
    place(*pair);
  }
  std::vector<Proposal> proposals;
  for (const AlignedPair& placed : branches_.front().placed()) {
    const double share = share_of(placed);
    for (std::size_t k = 0; k < placed.features.size(); ++k) {
      Match match = placed.matches[k];
      match.placement_probability *= share;
      if (match.placement_probability < matching_.placement_confidence()) continue;
      match.probability *= match.placement_probability * probability_of(match.score - matching_.log_pairs());
      const auto& [one, other] = placed.features[k];
      const MapPair<Dim>& pair = pairs_[placed.pair];
      if (match.probability >= confidence_) proposals.push_back({one, other, match, {pair.maps[0], pair.maps[1]}});
    }
  }
  return proposals;
}

template class JointAlignment<2>;
template class JointAlignment<3>;

}  // namespace mapjoin
