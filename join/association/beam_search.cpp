// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>
#include <mapjoin/join/association/beam_search.hpp>
#include <memory>
#include <unordered_map>
#include <utility>

namespace mapjoin {
namespace {

/// The most branches followed from sighting to sighting.
constexpr std::size_t kMostBranches = 40;

/// A pairing of a branch after those before it: a node of the tree of all branches, which have most of their pairings in
/// common.
template <int Dim>
struct Node {
  std::shared_ptr<const Node> before;  // null for the first pairing
  Pairing pairing;
  PointMatrix<Dim> L;                      // with L Lᵀ the covariance of the difference, given the pairings before it
  Point<Dim> whitened;                     // L⁻¹ times the difference, given these
  std::vector<PointMatrix<Dim>> coupling;  // the blocks of the row of the Cholesky factor before L, transposed
};

/// A hypothesis as the node of its last pairing; null if it has none.
template <int Dim>
struct Branch {
  std::shared_ptr<const Node<Dim>> last;
  double score = 0.0;
  double squared_distance = 0.0;
  Eigen::Index rows = 0;  // of all differences

  bool takes(std::size_t known) const {
    for (const Node<Dim>* node = last.get(); node; node = node->before.get()) {
      if (node->pairing.known == known) return true;
    }
    return false;
  }
};

/// The nodes of some branches, each after those before it.
template <int Dim>
class BranchTree {
 public:
  /// Refers to `branches`.
  explicit BranchTree(const std::vector<Branch<Dim>>& branches) : branches_(branches) {
    for (const Branch<Dim>& branch : branches) last_.push_back(add(branch.last.get()));
  }

  /// What each branch leaves of a pairing, by branch, computed once for the nodes that branches share.
  std::vector<Remainder<Dim>> remainders(const PairingProblem<Dim>& problem, const Pairing& pairing) {
    const Remainder<Dim> whole{problem.difference(pairing), problem.covariance_of(pairing, pairing)};
    for (Place& place : places_) {
      const Node<Dim>& node = *place.node;
      PointMatrix<Dim> covariance = problem.covariance_of(node.pairing, pairing);
      std::size_t at = place.before;
      for (auto block = node.coupling.rbegin(); block != node.coupling.rend(); ++block, at = places_[at].before) {
        covariance.noalias() -= block->transpose() * places_[at].coupling;
      }
      place.coupling = node.L.template triangularView<Eigen::Lower>().solve(covariance);
      place.left = place.before == kNone ? whole : places_[place.before].left;
      place.left.covariance.noalias() -= place.coupling.transpose() * place.coupling;
      place.left.difference.noalias() -= place.coupling.transpose() * node.whitened;
    }
    std::vector<Remainder<Dim>> left;
    for (const std::size_t last : last_) left.push_back(last == kNone ? whole : places_[last].left);
    return left;
  }

  /// The branch of this number extended by the pairing of the last call of remainders().
  Branch<Dim> extended(std::size_t number, const Extension<Dim>& by) const {
    const Branch<Dim>& branch = branches_[number];
    std::vector<PointMatrix<Dim>> coupling;
    for (std::size_t at = last_[number]; at != kNone; at = places_[at].before) coupling.push_back(places_[at].coupling);
    std::ranges::reverse(coupling);
    auto node = std::make_shared<const Node<Dim>>(
        Node<Dim>{branch.last, by.pairing, by.covariance.llt().matrixL(), by.whitened, std::move(coupling)});
    return {std::move(node), branch.score + by.gain, branch.squared_distance + by.squared_distance(), branch.rows + Dim};
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  /// A node in the list of all, which comes after those before it.
  struct Place {
    const Node<Dim>* node;
    std::size_t before;                                    // the place of the node before it; kNone if there is none
    PointMatrix<Dim> coupling = PointMatrix<Dim>::Zero();  // of the pairing in question
    Remainder<Dim> left = {};                              // of it, given the node and those before it
  };

  /// Adds a node and those before it that are not there yet; returns its place.
  std::size_t add(const Node<Dim>* node) {
    std::vector<const Node<Dim>*> fresh;
    for (; node && !place_of_.contains(node); node = node->before.get()) fresh.push_back(node);
    std::size_t before = node ? place_of_.at(node) : kNone;
    for (auto next = fresh.rbegin(); next != fresh.rend(); ++next) {
      place_of_.emplace(*next, places_.size());
      places_.push_back({*next, std::exchange(before, places_.size())});
    }
    return before;
  }

  const std::vector<Branch<Dim>>& branches_;
  std::vector<Place> places_;
  std::unordered_map<const Node<Dim>*, std::size_t> place_of_;
  std::vector<std::size_t> last_;  // by branch
};

/// The branches as they are and with each pairing of a sighting that can be added; the best ones, the best first.
template <int Dim>
std::vector<Branch<Dim>> followed(const std::vector<Branch<Dim>>& branches, std::size_t sighting,
                                  const PairingProblem<Dim>& problem, const std::vector<std::size_t>& forbidden,
                                  const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates) {
  BranchTree<Dim> tree(branches);
  std::vector<Branch<Dim>> next = branches;
  for (const std::size_t known : problem.choices[sighting]) {
    if (std::ranges::find(forbidden, known) != forbidden.end()) continue;
    const Pairing pairing{known, sighting};
    const auto left = tree.remainders(problem, pairing);
    for (std::size_t k = 0; k < branches.size(); ++k) {
      const Branch<Dim>& branch = branches[k];
      if (branch.takes(known)) continue;
      const auto extension = extension_by<Dim>(pairing, left[k], branch.rows, branch.squared_distance, density, gates);
      if (extension) next.push_back(tree.extended(k, *extension));
    }
  }
  std::ranges::stable_sort(next, std::greater<>(), &Branch<Dim>::score);
  next.resize(std::min(kMostBranches, next.size()));
  return next;
}

}  // namespace

template <int Dim>
Hypothesis<Dim> best_hypothesis(const PairingProblem<Dim>& problem, std::span<const std::size_t> order,
                                const ForbiddenPairings& forbidden, const NeighbourDensity<Dim>& density,
                                ChiSquaredQuantiles& gates) {
  std::vector<Branch<Dim>> branches(1);
  for (const std::size_t sighting : order) {
    branches = followed(branches, sighting, problem, forbidden[sighting], density, gates);
  }
  std::vector<Pairing> pairings;
  for (const Node<Dim>* node = branches.front().last.get(); node; node = node->before.get()) pairings.push_back(node->pairing);
  std::ranges::reverse(pairings);
  Hypothesis<Dim> best(problem);  // which has its whole factor in one matrix
  best.extend_by(pairings, density, gates);
  return best;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                               \
  template Hypothesis<Dim> best_hypothesis(const PairingProblem<Dim>&, std::span<const std::size_t>, const ForbiddenPairings&, \
                                           const NeighbourDensity<Dim>&, ChiSquaredQuantiles&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
