// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The joined map of sightings under assumed associations, with covariances.

#include <mapjoin/join/association/identities.hpp>
#include <mapjoin/join/covariances/map_covariances.hpp>
#include <mapjoin/join/fit/leave_one_out.hpp>
#include <mapjoin/join/restored.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// The sightings of a set: the features of its local maps, in their order, then its observations.
template <int Dim>
std::vector<Sighting> sightings_of(const SubmapSet<Dim>& set);
/// The sightings of a log: its observations, in their order.
template <int Dim>
std::vector<Sighting> sightings_of(const Log<Dim>& log, const Split& split);

/// The pose and the name of a sighting in its input.
struct NamedSighting {
  PoseIndex base;     ///< The pose it was seen from; for a feature of a local map, the base of the map.
  FeatureIndex name;  ///< The feature that it is said to be of.
};
/// The sightings of a set or a log in the order of sightings_of().
template <int Dim>
std::vector<NamedSighting> named_sightings(const SubmapSet<Dim>& set);
template <int Dim>
std::vector<NamedSighting> named_sightings(const Log<Dim>& log);

/// A set or a log whose features are those of `identities`, under the names 1, 2, … in the order of first sighting.
template <int Dim>
SubmapSet<Dim> renamed(SubmapSet<Dim> set, const Identities& identities);
template <int Dim>
Log<Dim> renamed(Log<Dim> log, const Identities& identities);

/// The connected components (parts) of poses and features, such as sessions that nothing ties together, numbered from 0 in the
/// order of their first poses.
struct PartNumbers {
  Table<PoseIndex, std::uint32_t> of_pose;
  Table<FeatureIndex, std::uint32_t> of_feature;
  std::vector<PoseIndex> first_poses;
  std::optional<std::uint32_t> in_world;  ///< The part that fixed poses or priors tie to the World; nullopt if none.
};

/// The parts of a log or a set; each of its features must be observed.
template <typename Data>
PartNumbers part_numbers_of(const Data& data);

/// Anchors the first pose of each part if there are several, except of the one that the World ties; returns the parts.
template <typename Data>
PartNumbers hold_parts(Data& data);

/// A joined map with its covariances.
template <int Dim>
struct FeatureEstimate {
  std::shared_ptr<const void> data;  ///< The log or set that the other members point into.
  std::unique_ptr<Restored<Dim>> restored;
  std::unique_ptr<const MapCovariances<Dim>> covariances;
  std::unique_ptr<const Marginals> marginals;
  PartNumbers parts;               ///< The parts, each in a frame of its own.
  std::vector<bool> is_local_map;  ///< False for a map of the sightings that is observations on their own.
  double scale = 1.0;              ///< The factor by which covariances are to be multiplied.

  const Point<Dim>& position(FeatureIndex feature) const { return covariances->state().features[feature]; }
  /// The variables of features, in their order.
  std::vector<Variable> variables_of(const std::vector<FeatureIndex>& features) const;
};

/// Joins the local maps of a set, or of a log cut along `split`, after hold_parts(). Errors as of join(); kInterrupted on
/// `stop`.
template <int Dim>
Expected<FeatureEstimate<Dim>> estimate_of(SubmapSet<Dim> set, const std::stop_token& stop);
template <int Dim>
Expected<FeatureEstimate<Dim>> estimate_of(Log<Dim> log, Split split, const std::stop_token& stop);

}  // namespace mapjoin
