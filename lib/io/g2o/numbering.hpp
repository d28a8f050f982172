// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The one numbering that g2o's programs expect of a file, shared by the poses of all sessions and the features.

#include <cstdint>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/ids.hpp>
#include <string>
#include <vector>

namespace mapjoin {

/// The numbers of poses and features: a pose's is its key plus its session times `session_step`, a feature's is its key plus
/// `feature_offset`. Both are powers of ten, so that the user's names stay readable, or 0 if keys do not meet anyway. GTSAM
/// symbols keep their letter.
struct G2oNumbering {
  std::uint64_t session_step = 0;
  std::uint64_t feature_offset = 0;

  std::uint64_t operator()(const PoseId& id) const { return id.key + id.session * session_step; }
  std::uint64_t operator()(const FeatureId& id) const { return id.key + feature_offset; }
};

/// What the numbering changes, a sentence without its end for each; empty if all keep their keys.
std::vector<std::string> in_words(const G2oNumbering& numbering);

/// The numbering of these poses and features; kUsage if their keys are so large that no such numbers fit into 64 bits.
Expected<G2oNumbering> number_for_g2o(const std::vector<PoseId>& poses, const std::vector<FeatureId>& features);

}  // namespace mapjoin
