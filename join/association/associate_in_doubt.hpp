// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Data association of a log or a set whose closures or names may be wrong.

#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <stop_token>

namespace mapjoin {

/// Finds which observations are of the same feature, as associate() does, but so that outliers do not mislead it. The result
/// holds all that `log` does; find_inliers() tells the outliers by the features found.
///
/// Where names hold, what find_inliers() rejects within the parts takes no part; a rejected observation goes with its name.
/// Otherwise features are found without closures, but for those that alone tie poses; by these features find_inliers() judges
/// all closures (and odometry, if robust.odometry), and features are found anew with what it keeps, until it keeps the same, or
/// three times in all. If it then rejects closures that others support (ClosureSupport), the same is begun with these, and the
/// outcome with fewer features and rejected measurements is taken. Errors as of associate() and find_inliers().
template <int Dim>
Expected<Associated<Log<Dim>>> associate_in_doubt(const Log<Dim>& log, const AssociationOptions& options,
                                                  const RobustOptions& robust, const std::stop_token& stop = {});

/// Finds which features and observations of a set are the same, as for a log; all that relates its poses is believed.
template <int Dim>
Expected<Associated<SubmapSet<Dim>>> associate_in_doubt(const SubmapSet<Dim>& set, const AssociationOptions& options,
                                                        const RobustOptions& robust, const std::stop_token& stop = {});

}  // namespace mapjoin
