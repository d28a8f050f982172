// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The search for features that are the same, join after join.

#include <cstdint>
#include <functional>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/association/frames/part_ties.hpp>
#include <mapjoin/join/association/map_matching.hpp>
#include <mapjoin/join/association/sighting_fit.hpp>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

namespace mapjoin {

/// The gates of a search: those of all sightings together, which no right match should miss, or at first those of one, which
/// what fits badly misses, though it may be right.
enum class SearchGates : std::uint8_t { kWide, kNarrowFirst };

/// Finds identities by joining with those known so far.
template <int Dim>
class IdentitySearch {
 public:
  /// Joins the map under given identities.
  using EstimateOf = std::function<Expected<FeatureEstimate<Dim>>(const Identities&)>;

  /// `matches` are by sighting, with its feature so far; nullopt if not matched.
  IdentitySearch(Identities identities, std::vector<std::optional<Match>> matches, const NeighbourDensity<Dim>& density,
                 const AssociationOptions& options, EstimateOf estimate_of, SearchGates gates, const std::stop_token& stop);

  /// Searches until nothing changes or most_joins is reached. Errors as of EstimateOf; kInterrupted on stop.
  Expected<void> run();

  const Identities& identities() const { return identities_; }
  /// The last match of each sighting with its feature; nullopt if it was not matched.
  const std::vector<std::optional<Match>>& matches() const { return matches_; }
  std::size_t joins() const { return joins_; }
  bool is_settled() const { return is_settled_; }
  /// The first poses of the parts to which parts_apart() refers, which tells why each pair stays apart.
  const std::vector<PoseIndex>& first_poses() const { return first_poses_; }
  const std::vector<PartsApart>& parts_apart() const { return parts_apart_; }
  double gate() const { return gate_; }

 private:
  double sightings() const { return static_cast<double>(identities_.sighting_count()); }
  bool is_first_join() const { return joins_ == 1; }
  /// Lets features that were told apart be the same again, once: the map may have been bent when they were.
  bool forgive() { return !std::exchange(has_forgiven_, true) && identities_.forgive(); }
  bool undo(const std::vector<SightingTest>& misfits);
  /// The sightings of a feature by the misfitting map or, if names hold, by the part of that map; empty if these are all.
  std::vector<std::size_t> taken_with(const SightingTest& misfit) const;
  /// Merges probable matches within the gates.
  bool extend(const FeatureEstimate<Dim>& estimate);
  /// Merges probable matches within the gates of so many decisions: all of maps that are in place; if there are none, those of
  /// maps aligned together, or of the surest pair of maps.
  bool extend(const FeatureEstimate<Dim>& estimate, double decisions);
  /// Merges probable matches of maps that could lie on each other in several ways, all of them together.
  bool align_together(const FeatureEstimate<Dim>& estimate, const MapMatching<Dim>& matching);
  /// Merges probable matches of the surest pair of maps that are not in place.
  bool take_surest(const MapMatching<Dim>& matching);
  /// Aligns parts by constellations of their features. True if any features were merged.
  Expected<bool> tie_parts(const FeatureEstimate<Dim>& estimate);
  bool take(std::vector<Proposal> proposals);

  Identities identities_;
  const NeighbourDensity<Dim>& density_;
  const AssociationOptions& options_;
  EstimateOf estimate_of_;
  SearchGates gates_;
  const std::stop_token& stop_;
  double gate_;
  std::vector<std::optional<Match>> matches_;
  std::size_t joins_ = 0;
  bool has_forgiven_ = false;
  bool is_settled_ = false;
  std::vector<PoseIndex> first_poses_;
  std::vector<PartsApart> parts_apart_;
};

}  // namespace mapjoin
