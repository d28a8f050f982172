// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Data association: finds which features are the same in logs and local maps without names, or with untrusted ones.

#include <functional>
#include <mapjoin/io/store/contents.hpp>
#include <mapjoin/join/association/frames/map_alignment.hpp>
#include <mapjoin/join/association/matching/matching.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin {

struct AssociationOptions {
  double confidence = 0.99;  ///< The least probability of an accepted pairing; in (0, 1).
  AssociationMethod method = AssociationMethod::kJcbb;
  /// True if names are right within each part that they tie together; only parts that nothing ties are then matched.
  bool names_hold = false;
  std::size_t most_joins = 100;               ///< The most joins of a search, which then ends, settled or not.
  std::function<void(std::size_t)> progress;  ///< Called with the number of joins so far.

  /// Every violation in words; empty if the options are valid.
  std::vector<std::string> validate() const;
};

/// A sighting, its feature in the result, and the match between the two.
struct AssociatedSighting {
  PoseId base;                     ///< The pose it was seen from; for a feature of a local map, the base of the map.
  FeatureId name;                  ///< Name of the feature in the input.
  FeatureId joined;                ///< Name of the feature in the result.
  std::optional<double> distance;  ///< Mahalanobis distance when matched; nullopt if never matched, as a first sighting.
  double gate = 0.0;               ///< The largest distance allowed.
  std::size_t alternatives = 0;    ///< Number of other features within the gate when matched.
};

/// Two parts, by their first poses, that nothing ties together, and the alignment that was not accepted.
struct UntiedParts {
  PoseId first;
  PoseId second;
  MapAlignment alignment;
};

/// A log or a set with its associated features, which are called 1, 2, … in the order of their first sighting.
template <typename Data>
struct Associated {
  Data data;
  std::vector<AssociatedSighting> sightings;  ///< In order: observations of a log; features of a set's maps, then observations.
  std::size_t joins = 0;                      ///< Number of joins of both searches.
  bool is_settled = false;                    ///< True if the last join found nothing more to merge or to tell apart.
  std::vector<UntiedParts> untied;            ///< Every pair of parts that stay apart; empty if there is one part only.
};

/// Finds which observations of a log are of the same feature. Names are ignored unless options.names_hold.
///
/// Observations are tracked within short segments (track()), whose local maps are joined. With the joined map and its
/// covariances, maps are matched with each other (MapMatching), first neighbours, then all that probably overlap, repeatedly
/// until nothing more is found; then maps that could lie on each other in several ways, all together (JointAlignment), and maps
/// whose relative pose is hardly known, the surest pair at a time. Sightings that no longer fit, by leave-one-out tests, are
/// told apart again and get one second chance in the end. Where that came to rest with fewer features, all this is done
/// once more, first with what fits well alone; the result is the one with fewer features. Parts that no edge ties, such as
/// sessions of unknown frames, are first associated each by itself, then aligned by constellations of their features
/// (align_maps()); those that cannot be aligned stay apart. kBadInput if check_invariants() finds a fault, or priors of
/// features, which refer to their names; other errors as of join(); kInterrupted on `stop`. The result is the same for any
/// number of threads.
template <int Dim>
Expected<Associated<Log<Dim>>> associate(const Log<Dim>& log, const AssociationOptions& options,
                                         const std::stop_token& stop = {});

/// Finds which features and observations of a set are the same, as for a log; each local map sees a feature once at most.
template <int Dim>
Expected<Associated<SubmapSet<Dim>>> associate(const SubmapSet<Dim>& set, const AssociationOptions& options,
                                               const std::stop_token& stop = {});

/// Finds which features of different inputs are the same, as associate() does in their logs, and renames the features of the
/// local maps accordingly; the join is then that of one log. Throws std::invalid_argument unless options.names_hold, as the
/// maps were built by names. Errors as of associate().
template <int Dim>
Expected<Associated<StoredMaps<Dim>>> associate(const StoredMaps<Dim>& stored, const AssociationOptions& options,
                                                const std::stop_token& stop = {});

}  // namespace mapjoin
