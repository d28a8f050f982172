// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A test of whether features of one name lie alike in sessions that only such names tie together.

#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <optional>
#include <stop_token>

namespace mapjoin {

/// The agreement between the maps of two parts on the features of one name.
struct NameFit {
  PoseId first;  ///< The first pose of the one part; `second` is that of the other.
  PoseId second;
  std::size_t features = 0;  ///< Number of features that both name.
  double alike = 1.0;        ///< Share of the distances between two of these features that are the same in both maps.

  /// True if most distances are the same, as of features that are the same.
  bool is_good() const { return alike > 0.5; }
};

/// The two parts whose features of one name lie least alike; nullopt if no two share two such features. Parts are tied together
/// by poses, and each is joined alone; where these maps do not fit, again without what contradicts the rest of a part
/// (find_inliers()), since one wrong observation bends a map. Priors of features do not count. Distances count as the same
/// within what the covariances of the maps allow with probability `confidence`. Errors as of join() and find_inliers();
/// kInterrupted on `stop`.
template <int Dim>
Expected<std::optional<NameFit>> worst_name_fit(const Log<Dim>& log, double confidence, const std::stop_token& stop = {});
template <int Dim>
Expected<std::optional<NameFit>> worst_name_fit(SubmapSet<Dim> set, double confidence, const std::stop_token& stop = {});

}  // namespace mapjoin
