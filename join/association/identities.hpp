// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The association of sightings with features.

#include <algorithm>
#include <cstddef>
#include <mapjoin/model/ids.hpp>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// A feature of a local map, or an observation of a log.
struct Sighting {
  std::size_t map = 0;   ///< The local map or the segment; for an observation of a set, its pose.
  std::size_t scan = 0;  ///< Unit in which different labels are different features: a local map, the pose of an observation or,
                         ///< if names hold, a part.
};

/// A partition of sightings into features, which are numbered in the order of their first sighting.
class Identities {
 public:
  /// Sightings of equal labels are of the same feature.
  Identities(std::vector<Sighting> sightings, std::vector<std::size_t> labels);

  std::size_t sighting_count() const { return sightings_.size(); }
  std::size_t feature_count() const { return members_.size(); }
  std::size_t map_count() const { return in_map_.size(); }
  const Sighting& sighting(std::size_t sighting) const { return sightings_[sighting]; }
  FeatureIndex feature_of(std::size_t sighting) const { return feature_of_[sighting]; }
  /// The sightings of a feature, ascending.
  std::span<const std::size_t> sightings_of(FeatureIndex feature) const { return members_[feature]; }
  /// The features that a map sees, ascending; empty if it sees none.
  std::span<const FeatureIndex> features_in(std::size_t map) const {
    return map < in_map_.size() ? std::span<const FeatureIndex>(in_map_[map]) : std::span<const FeatureIndex>();
  }

  /// True if a map sees a feature.
  bool sees(std::size_t map, FeatureIndex feature) const { return std::ranges::binary_search(features_in(map), feature); }

  /// False if a scan sees both, or if they have been told apart.
  bool may_be_same(FeatureIndex one, FeatureIndex other) const;

  /// Merges each pair that may still be the same when its turn comes. Returns for each pair the sightings that thereby move to
  /// a feature seen before.
  std::vector<std::vector<std::size_t>> merge(std::span<const std::pair<FeatureIndex, FeatureIndex>> pairs);
  /// Makes sightings of one feature a feature of their own, which is not the same as the rest of the old one from here on.
  void tell_apart(std::span<const std::size_t> sightings);
  /// Lets features that were told apart be the same again. True if there were any.
  bool forgive();

 private:
  void number(const std::vector<std::size_t>& labels);

  std::vector<Sighting> sightings_;
  std::vector<FeatureIndex> feature_of_;
  Table<FeatureIndex, std::vector<std::size_t>> members_;
  Table<FeatureIndex, std::vector<std::size_t>> scans_;  // scans of the members, ascending
  std::vector<std::vector<FeatureIndex>> in_map_;
  std::vector<std::vector<std::size_t>> apart_from_;  // by sighting, those of other features
};

}  // namespace mapjoin
