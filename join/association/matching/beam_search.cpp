// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <functional>
#include <mapjoin/join/association/matching/beam_search.hpp>
#include <memory>
#include <optional>
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
  Point<Dim> whitened;  // the difference, given the pairings before it, in standard deviations
  /// Of all points with `whitened`, given the pairings before it (m); rows as in PairingProblem::covariance.
  Eigen::Matrix<double, Eigen::Dynamic, Dim> cross_covariance;

  /// The block of the Cholesky factor in the rows of another pairing and the columns of this one (m).
  PointMatrix<Dim> coupling(const PairingProblem<Dim>& problem, const Pairing& other) const {
    return cross_covariance.template middleRows<Dim>(problem.row_of_known(other.known)) -
           cross_covariance.template middleRows<Dim>(problem.row_of_sighting(other.sighting));
  }
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

/// The branch with one pairing more. With d its difference, L Lᵀ the covariance of d given the pairings j before it, and wⱼ
/// theirs, whitened, the cross-covariance of the points x is (Cov(x, d) − Σⱼ Cov(x, wⱼ) Cov(d, wⱼ)ᵀ) L⁻ᵀ.
template <int Dim>
Branch<Dim> extended(const Branch<Dim>& branch, const Extension<Dim>& by, const PairingProblem<Dim>& problem) {
  Node<Dim> node{branch.last, by.pairing, by.whitened,
                 problem.covariance.template middleCols<Dim>(problem.row_of_known(by.pairing.known)) -
                     problem.covariance.template middleCols<Dim>(problem.row_of_sighting(by.pairing.sighting))};
  for (const Node<Dim>* before = branch.last.get(); before; before = before->before.get()) {
    node.cross_covariance.noalias() -= before->cross_covariance * before->coupling(problem, by.pairing).transpose();
  }
  const PointMatrix<Dim> L = by.covariance.llt().matrixL();
  L.transpose().template triangularView<Eigen::Upper>().template solveInPlace<Eigen::OnTheRight>(node.cross_covariance);
  return {std::make_shared<const Node<Dim>>(std::move(node)), branch.score + by.gain,
          branch.squared_distance + by.squared_distance(), branch.rows + Dim};
}

/// The nodes of some branches, each after those before it.
template <int Dim>
class BranchTree {
 public:
  explicit BranchTree(const std::vector<Branch<Dim>>& branches) {
    for (const Branch<Dim>& branch : branches) last_.push_back(add(branch.last.get()));
  }

  /// What each branch leaves of a pairing, by branch, computed once for the nodes that branches share.
  std::vector<Remainder<Dim>> remainders(const PairingProblem<Dim>& problem, const Pairing& pairing) const {
    const Remainder<Dim> whole{problem.difference(pairing), problem.covariance_of(pairing, pairing)};
    std::vector<Remainder<Dim>> left;  // by place
    for (const Place& place : places_) {
      const PointMatrix<Dim> coupling = place.node->coupling(problem, pairing);
      Remainder<Dim> remainder = place.before == kNone ? whole : left[place.before];
      remainder.covariance.noalias() -= coupling * coupling.transpose();
      remainder.difference.noalias() -= coupling * place.node->whitened;
      left.push_back(remainder);
    }
    std::vector<Remainder<Dim>> of_branches;
    for (const std::size_t last : last_) of_branches.push_back(last == kNone ? whole : left[last]);
    return of_branches;
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  /// A node in the list of all, which comes after those before it.
  struct Place {
    const Node<Dim>* node;
    std::size_t before;  // the place of the node before it; kNone if there is none
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

  std::vector<Place> places_;
  std::unordered_map<const Node<Dim>*, std::size_t> place_of_;
  std::vector<std::size_t> last_;  // by branch
};

/// A branch as it is, or with one pairing more.
template <int Dim>
struct Step {
  const Branch<Dim>* branch;
  std::optional<Extension<Dim>> by = {};

  double score() const { return branch->score + (by ? by->gain : 0.0); }
};

/// The branches as they are and with each pairing of a sighting that can be added; the best ones, the best first.
template <int Dim>
std::vector<Branch<Dim>> followed(const std::vector<Branch<Dim>>& branches, std::size_t sighting,
                                  const PairingProblem<Dim>& problem, const std::vector<std::size_t>& forbidden,
                                  const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates) {
  const BranchTree<Dim> tree(branches);
  std::vector<Step<Dim>> steps;
  for (const Branch<Dim>& branch : branches) steps.push_back({&branch});
  for (const std::size_t known : problem.choices[sighting]) {
    if (std::ranges::find(forbidden, known) != forbidden.end()) continue;
    const Pairing pairing{known, sighting};
    const auto left = tree.remainders(problem, pairing);
    for (std::size_t k = 0; k < branches.size(); ++k) {
      const Branch<Dim>& branch = branches[k];
      if (branch.takes(known)) continue;
      auto extension = extension_by<Dim>(pairing, left[k], branch.rows, branch.squared_distance, density, gates);
      if (extension) steps.push_back({&branch, std::move(extension)});
    }
  }
  std::ranges::stable_sort(steps, std::greater<>(), &Step<Dim>::score);
  steps.resize(std::min(kMostBranches, steps.size()));
  std::vector<Branch<Dim>> next;
  for (const Step<Dim>& step : steps) next.push_back(step.by ? extended(*step.branch, *step.by, problem) : *step.branch);
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
