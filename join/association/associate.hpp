// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Who is who: the features of logs and local maps that have no names, or none that are trusted.

#include <functional>
#include <mapjoin/io/store/contents.hpp>
#include <mapjoin/join/association/frames/map_alignment.hpp>
#include <mapjoin/join/association/matching.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin {

struct AssociationOptions {
  double confidence = 0.99;  ///< The least probability of a pairing that is taken; in (0, 1).
  AssociationMethod method = AssociationMethod::kJcbb;
  /// Names are right within whatever hangs together by them; only parts that nothing ties are matched with each other.
  bool names_hold = false;
  std::size_t most_joins = 100;               ///< Then the search ends, settled or not.
  std::function<void(std::size_t)> progress;  ///< Called with the number of joins so far.

  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

/// What became of a sighting.
struct AssociatedSighting {
  PoseId base;       ///< That it was seen from: of a local map its start.
  FeatureId name;    ///< In the input.
  FeatureId joined;  ///< In the result.
  std::optional<double>
      distance;       ///< Mahalanobis, from the feature when it was taken for it; nothing where it is the first of it.
  double gate = 0.0;  ///< What the distance may be.
  std::size_t alternatives = 0;  ///< Other features within the gate then.
};

/// Two parts, by their first poses, that nothing ties together, and why.
struct UntiedParts {
  PoseId first;
  PoseId second;
  MapAlignment alignment;
};

/// A log or a set with features found in it, which are called 1, 2, … in the order of their first sighting.
template <typename Data>
struct Associated {
  Data data;
  std::vector<AssociatedSighting> sightings;  ///< Observations of a log in their order; features of maps, then observations.
  std::size_t joins = 0;                      ///< How often the map was joined.
  bool is_settled = false;                    ///< The last join found nothing more to be the same, and nothing to tell apart.
  std::vector<UntiedParts> untied;            ///< Every pair of parts; empty where all hangs together.
};

/// Finds out which observations of a log are of the same feature; their names are ignored.
///
/// Observations are followed within short segments (track()), whose local maps are joined. By the joined map, with its
/// covariances, maps are matched with each other (MapMatching), first neighbours, then all that probably overlap, again and
/// again, until nothing more is found; then those that could lie on each other in several ways, all together (JointAlignment),
/// and those that are far apart for all that is known, the surest pair at a time. What no longer fits, by leave-one-out tests,
/// is told apart again, and tried once more in the end. Parts that no edge ties, sessions of unknown frames say, are each taken
/// alone first, then aligned by constellations of their features (align_maps()); what cannot be aligned stays a part. Bad
/// input: priors of features, which mean their names. kInterrupted on `stop`. The same for any number of threads.
template <int Dim>
Expected<Associated<Log<Dim>>> associate(const Log<Dim>& log, const AssociationOptions& options,
                                         const std::stop_token& stop = {});

/// The same between local maps, of which each sees a feature once.
template <int Dim>
Expected<Associated<SubmapSet<Dim>>> associate(const SubmapSet<Dim>& set, const AssociationOptions& options,
                                               const std::stop_token& stop = {});

/// Finds out which features of different inputs are the same, as associate() does in their logs, and calls those of the local
/// maps by what they are found to be. A map inside which a feature was marginalised that others turn out to see, too, gives way
/// to its observations, so that the join is that of one log. Throws std::invalid_argument unless names hold: the maps were
/// built by them. Errors as of associate().
template <int Dim>
Expected<Associated<StoredMaps<Dim>>> associate(const StoredMaps<Dim>& stored, const AssociationOptions& options,
                                                const std::stop_token& stop = {});

}  // namespace mapjoin
