// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How the poses of all sessions and the features share the one numbering that g2o's programs expect of a file.

#include <cstdint>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/ids.hpp>
#include <vector>

namespace mapjoin {

/// A pose's number is its key plus its session times `session_step`, a feature's is its key plus `feature_offset`. Both are
/// powers of ten, for the user's names to shine through, or 0 where keys do not meet anyway. GTSAM symbols keep their letter.
struct G2oNumbering {
  std::uint64_t session_step = 0;
  std::uint64_t feature_offset = 0;

  std::uint64_t operator()(const PoseId& id) const { return id.key + id.session * session_step; }
  std::uint64_t operator()(const FeatureId& id) const { return id.key + feature_offset; }
};

/// kUsage where keys are so large that no such numbers fit into 64 bits.
Expected<G2oNumbering> number_for_g2o(const std::vector<PoseId>& poses, const std::vector<FeatureId>& features);

}  // namespace mapjoin
