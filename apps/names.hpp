// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The poses and features that a user names on the command line.

#include <mapjoin/model/error.hpp>
#include <mapjoin/model/ids.hpp>
#include <string_view>

namespace mapjoin::apps {

/// The pose or feature that a word names: `17` or, of a GTSAM symbol, `a17`; `1:17` is pose 17 of session 1. Where the word
/// could be either, or be a pose of several sessions, `pose:17`, `feature:17` and `1:17` tell. kUsage where it is none of them,
/// or several.
Expected<PoseOrFeature> find_named(std::string_view word, const PoseIds& poses, const FeatureIds& features);

}  // namespace mapjoin::apps
