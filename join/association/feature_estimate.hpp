// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The joined map of sightings whose features are taken to be known, with covariances.

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

/// A set or a log whose features are those of `identities`, under the names 1, 2, … in the order of first sighting.
template <int Dim>
SubmapSet<Dim> renamed(SubmapSet<Dim> set, const Identities& identities);
template <int Dim>
Log<Dim> renamed(Log<Dim> log, const Identities& identities);

/// What hangs together: sessions that nothing ties are parts. Numbered from 0 in the order of their first poses.
struct PartNumbers {
  Table<PoseIndex, std::uint32_t> of_pose;
  Table<FeatureIndex, std::uint32_t> of_feature;
  std::vector<PoseIndex> first_poses;
  std::optional<std::uint32_t> in_world;  ///< The part that fixed poses or priors tie to the World.
};

/// The parts of a log or a set, every feature of which is observed.
template <typename Data>
PartNumbers part_numbers_of(const Data& data);

/// A joined map and how certain it is.
template <int Dim>
struct FeatureEstimate {
  std::shared_ptr<const void> data;  ///< That all else points into.
  std::unique_ptr<Restored<Dim>> restored;
  std::unique_ptr<const MapCovariances<Dim>> covariances;
  std::unique_ptr<const Marginals> marginals;
  PartNumbers parts;               ///< Each in a frame of its own.
  std::vector<bool> is_local_map;  ///< By map of the sightings; else they stand on their own.
  double scale = 1.0;              ///< That covariances are to be multiplied by.
};

/// Joins the local maps of a set, or of a log that is cut along `split`. Where nothing ties all of it together, the first pose
/// of each part is held, but that of a part that the World ties. Errors as of join(); kInterrupted on `stop`.
template <int Dim>
Expected<FeatureEstimate<Dim>> estimate_of(SubmapSet<Dim> set, const std::stop_token& stop);
template <int Dim>
Expected<FeatureEstimate<Dim>> estimate_of(Log<Dim> log, Split split, const std::stop_token& stop);

}  // namespace mapjoin
