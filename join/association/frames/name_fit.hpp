// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Do features of one name lie alike in sessions that only such names tie together?

#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <optional>
#include <stop_token>

namespace mapjoin {

/// How the features that two parts name alike lie in the map of each.
struct NameFit {
  PoseId first;  ///< The first pose of either part.
  PoseId second;
  std::size_t features = 0;  ///< That both name.
  double alike = 1.0;        ///< The share of the distances between two of these that are the same in both maps.
};

/// Of the parts that poses tie together, each joined alone, the two whose features of one name lie least alike; nothing where
/// no two have two such features. Priors of features do not count. Distances count as the same within what the covariances of
/// the maps allow with probability `confidence`. Errors as of join(); kInterrupted on `stop`.
template <int Dim>
Expected<std::optional<NameFit>> worst_name_fit(const Log<Dim>& log, double confidence, const std::stop_token& stop = {});
template <int Dim>
Expected<std::optional<NameFit>> worst_name_fit(SubmapSet<Dim> set, double confidence, const std::stop_token& stop = {});

}  // namespace mapjoin
