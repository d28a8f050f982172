// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The search for what is the same, join after join.

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

/// Finds identities by joining with those known so far.
template <int Dim>
class IdentitySearch {
 public:
  /// The map that is joined with what is known.
  using EstimateOf = std::function<Expected<FeatureEstimate<Dim>>(const Identities&)>;

  /// `matches` are by sighting, how it was found to be of its feature so far.
  IdentitySearch(Identities identities, std::vector<std::optional<Match>> matches, const NeighbourDensity<Dim>& density,
                 const AssociationOptions& options, EstimateOf estimate_of, const std::stop_token& stop);

  /// Until nothing changes, or the options end it.
  Expected<void> run();

  const Identities& identities() const { return identities_; }
  /// By sighting, how it was last found to be of its feature.
  const std::vector<std::optional<Match>>& matches() const { return matches_; }
  std::size_t joins() const { return joins_; }
  bool is_settled() const { return is_settled_; }
  /// The parts that are left, where nothing ties all together: their first poses, and why each pair stays apart.
  const std::vector<PoseIndex>& first_poses() const { return first_poses_; }
  const std::vector<PartsApart>& parts_apart() const { return parts_apart_; }
  double gate() const { return gate_; }

 private:
  double sightings() const { return static_cast<double>(identities_.sighting_count()); }
  /// Gives what was told apart a second chance, once: the map may have been bent when it was.
  bool forgive() { return !std::exchange(has_forgiven_, true) && identities_.forgive(); }
  bool undo(const std::vector<SightingTest>& misfits);
  /// The sightings of a feature that a map has of it or, where names hold, the part that the map is of: none where all are.
  std::vector<std::size_t> taken_with(const SightingTest& misfit) const;
  /// Takes what is probable: of maps that are in place all of it, else of the pair of maps that is the surest.
  bool extend(const FeatureEstimate<Dim>& estimate);
  /// Takes what is probable of maps that could lie on each other in several ways, all of them together.
  bool align_together(const FeatureEstimate<Dim>& estimate, const MapMatching<Dim>& matching);
  /// Takes what is probable of the surest pair of maps that are not in place.
  bool take_surest(const MapMatching<Dim>& matching);
  /// Aligns parts that nothing ties by constellations of their features.
  Expected<bool> tie_parts(const FeatureEstimate<Dim>& estimate);
  bool take(std::vector<Proposal> proposals);

  Identities identities_;
  const NeighbourDensity<Dim>& density_;
  const AssociationOptions& options_;
  EstimateOf estimate_of_;
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
