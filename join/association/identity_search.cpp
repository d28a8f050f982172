// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/association/identity_search.hpp>
#include <mapjoin/join/association/joint_alignment.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Maps count as in place if no feature may be mistaken for more others than this.
constexpr double kInPlace = 1.0;
/// The factor by which the reach of matching grows each time that nothing is found nearer, and the reach at which it ends.
constexpr double kFarther = 32.0;
constexpr double kFarthest = 1e6;
}  // namespace

template <int Dim>
IdentitySearch<Dim>::IdentitySearch(Identities identities, std::vector<std::optional<Match>> matches,
                                    const NeighbourDensity<Dim>& density, const AssociationOptions& options,
                                    EstimateOf estimate_of, SearchGates gates, const std::stop_token& stop)
    : identities_(std::move(identities)),
      density_(density),
      options_(options),
      estimate_of_(std::move(estimate_of)),
      gates_(gates),
      stop_(stop),
      gate_(Matcher<Dim>(density, options.method, options.confidence, sightings()).gate()),
      matches_(std::move(matches)) {}

template <int Dim>
Expected<void> IdentitySearch<Dim>::run() {
  while (!is_settled_ && joins_ < options_.most_joins) {
    ++joins_;
    auto estimate = estimate_of_(identities_);
    if (!estimate) return tl::unexpected(estimate.error());
    if (options_.progress) options_.progress(joins_);
    const std::vector<SightingTest> tests = tests_of(*estimate, identities_);
    estimate->scale = overconfidence_of(tests, Dim);
    const bool has_changed = undo(misfits(tests, gate_ * estimate->scale)) || extend(*estimate);
    if (stop_.stop_requested()) return interrupted("associating");
    if (has_changed || forgive()) continue;
    parts_apart_.clear();
    const auto is_tied = estimate->parts.first_poses.size() > 1 ? tie_parts(*estimate) : Expected<bool>(false);
    if (!is_tied) return tl::unexpected(is_tied.error());
    is_settled_ = !*is_tied;
  }
  return {};
}

template <int Dim>
bool IdentitySearch<Dim>::undo(const std::vector<SightingTest>& misfits) {
  std::vector<std::vector<std::size_t>> apart;
  for (const SightingTest& misfit : misfits) {
    // The numbers of features change with each that is told apart, those of sightings do not.
    if (auto sightings = taken_with(misfit); !sightings.empty()) apart.push_back(std::move(sightings));
  }
  for (const auto& sightings : apart) {
    identities_.tell_apart(sightings);
    for (const std::size_t s : sightings) matches_[s].reset();
  }
  return !apart.empty();
}

template <int Dim>
std::vector<std::size_t> IdentitySearch<Dim>::taken_with(const SightingTest& misfit) const {
  const auto all = identities_.sightings_of(misfit.feature);
  const auto of_map = [&](std::size_t s) { return identities_.sighting(s).map == misfit.map; };
  const std::size_t scan = identities_.sighting(*std::ranges::find_if(all, of_map)).scan;
  std::vector<std::size_t> taken;
  std::ranges::copy_if(all, std::back_inserter(taken),
                       [&](std::size_t s) { return options_.names_hold ? identities_.sighting(s).scan == scan : of_map(s); });
  if (taken.size() == all.size()) taken.clear();
  return taken;
}

template <int Dim>
bool IdentitySearch<Dim>::extend(const FeatureEstimate<Dim>& estimate) {
  if (gates_ == SearchGates::kNarrowFirst && !is_first_join() && extend(estimate, 1.0)) return true;
  return extend(estimate, sightings());
}

template <int Dim>
bool IdentitySearch<Dim>::extend(const FeatureEstimate<Dim>& estimate, double decisions) {
  const MapMatching<Dim> matching(estimate, identities_, density_, options_.method, options_.confidence, decisions);
  if (take(matching.propose(kInPlace, is_first_join(), stop_).probable)) return true;
  if (is_first_join()) return true;  // the next join matches all maps
  if (options_.method == AssociationMethod::kNearest) return false;
  return align_together(estimate, matching) || take_surest(matching);
}

template <int Dim>
bool IdentitySearch<Dim>::align_together(const FeatureEstimate<Dim>& estimate, const MapMatching<Dim>& matching) {
  JointAlignment<Dim> alignment(estimate, identities_, density_, matching, options_.confidence,
                                matching.pairs(kFarther, stop_));
  return take(alignment.propose(stop_));
}

template <int Dim>
bool IdentitySearch<Dim>::take_surest(const MapMatching<Dim>& matching) {
  for (double reach = kFarther; reach < kFarthest; reach *= kFarther) {
    auto [probable, beyond_reach] = matching.propose(reach, false, stop_);
    if (stop_.stop_requested()) return false;
    const auto surest = std::ranges::max_element(probable, {}, [](const Proposal& p) { return p.match.score; });
    if (surest != probable.end()) {
      const auto maps = std::pair(surest->maps[0], surest->maps[1]);
      std::erase_if(probable, [&](const Proposal& p) { return std::pair(p.maps[0], p.maps[1]) != maps; });
      if (take(std::move(probable))) return true;
    }
    if (beyond_reach == 0) break;
  }
  return false;
}

template <int Dim>
Expected<bool> IdentitySearch<Dim>::tie_parts(const FeatureEstimate<Dim>& estimate) {
  auto found = ties_between_parts(estimate, identities_, density_, options_.confidence, stop_);
  if (!found) return tl::unexpected(found.error());
  first_poses_ = estimate.parts.first_poses;
  parts_apart_ = std::move(found->apart);
  const auto moved = identities_.merge(found->ties);
  return std::ranges::any_of(moved, [](const auto& sightings) { return !sightings.empty(); });
}

template <int Dim>
bool IdentitySearch<Dim>::take(std::vector<Proposal> proposals) {
  std::ranges::stable_sort(proposals, std::greater<>(), [](const Proposal& p) { return p.match.probability; });
  std::vector<std::pair<FeatureIndex, FeatureIndex>> pairs;
  for (const Proposal& p : proposals) pairs.emplace_back(p.one, p.other);
  const auto moved = identities_.merge(pairs);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    for (const std::size_t s : moved[k]) matches_[s] = proposals[k].match;
  }
  return std::ranges::any_of(moved, [](const auto& sightings) { return !sightings.empty(); });
}

template class IdentitySearch<2>;
template class IdentitySearch<3>;

}  // namespace mapjoin
