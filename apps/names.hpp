// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The poses and features that a user names on the command line.

#include <mapjoin/model/error.hpp>
#include <mapjoin/model/ids.hpp>
#include <string_view>

namespace mapjoin::apps {

/// The pose or feature that a word names: `17` or, for a GTSAM symbol, `a17`; `1:17` is pose 17 of session 1. `pose:17`,
/// `feature:17` and `1:17` tell apart a pose, a feature and poses of several sessions with this number. kUsage if the word
/// names none, or several.
Expected<PoseOrFeature> find_named(std::string_view word, const PoseIds& poses, const FeatureIds& features);

}  // namespace mapjoin::apps
