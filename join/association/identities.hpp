// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Which sightings are of the same feature.

#include <cstddef>
#include <mapjoin/model/ids.hpp>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// A feature of a local map, or an observation of a log.
struct Sighting {
  std::size_t map = 0;   ///< The local map, or the segment that the observation belongs to.
  std::size_t scan = 0;  ///< What gives different features different labels: a local map, or the pose of an observation.
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
  /// Ascending.
  std::span<const std::size_t> sightings_of(FeatureIndex feature) const { return members_[feature]; }
  /// Ascending; none of a map that sees nothing.
  std::span<const FeatureIndex> features_in(std::size_t map) const {
    return map < in_map_.size() ? std::span<const FeatureIndex>(in_map_[map]) : std::span<const FeatureIndex>();
  }

  /// Not where something sees both at once, or where they have been told apart.
  bool may_be_same(FeatureIndex one, FeatureIndex other) const;

  /// Makes one feature of each pair that may still be the same when its turn comes. Returns for each pair the sightings that
  /// have thereby become ones of a feature that was seen before.
  std::vector<std::vector<std::size_t>> merge(std::span<const std::pair<FeatureIndex, FeatureIndex>> pairs);
  /// Makes sightings of one feature a feature of their own, which is not the same as the rest of it from here on.
  void tell_apart(std::span<const std::size_t> sightings);
  /// Lets what was told apart be the same again. Whether there was anything.
  bool forgive();

 private:
  void number(const std::vector<std::size_t>& labels);

  std::vector<Sighting> sightings_;
  std::vector<FeatureIndex> feature_of_;
  Table<FeatureIndex, std::vector<std::size_t>> members_;
  Table<FeatureIndex, std::vector<std::size_t>> scans_;  // of the members, ascending
  std::vector<std::vector<FeatureIndex>> in_map_;
  std::vector<std::vector<std::size_t>> apart_from_;  // by sighting, others, ascending
};

}  // namespace mapjoin
