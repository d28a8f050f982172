// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <limits>
#include <mapjoin/io/g2o/numbering.hpp>
#include <optional>

namespace mapjoin {
namespace {

constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();

/// The smallest power of ten above `number`.
std::optional<std::uint64_t> power_of_ten_above(std::uint64_t number) {
  std::uint64_t power = 1;
  while (power <= number) {
    if (power > kMost / 10) return std::nullopt;
    power *= 10;
  }
  return power;
}

/// Whether a pose and a feature have the same key; both lists are copies, sorted here.
bool meet(std::vector<std::uint64_t> poses, std::vector<std::uint64_t> features) {
  std::sort(poses.begin(), poses.end());
  std::sort(features.begin(), features.end());
  std::vector<std::uint64_t> both;
  std::ranges::set_intersection(poses, features, std::back_inserter(both));
  return !both.empty();
}

}  // namespace

Expected<G2oNumbering> number_for_g2o(const std::vector<PoseId>& poses, const std::vector<FeatureId>& features) {
  const tl::unexpected<Error> too_large(
      Error{ErrorKind::kUsage,
            "a g2o file has one numbering of 64 bits, into which the keys of these poses and features do not fit"});
  std::uint64_t largest_pose = 0;
  std::uint32_t last_session = 0;
  for (const PoseId& id : poses) {
    largest_pose = std::max(largest_pose, id.key);
    last_session = std::max(last_session, id.session);
  }
  std::uint64_t largest_feature = 0;
  for (const FeatureId& id : features) largest_feature = std::max(largest_feature, id.key);

  G2oNumbering numbering;
  if (last_session > 0) {
    const auto step = power_of_ten_above(largest_pose);
    if (!step || *step > (kMost - largest_pose) / last_session) return too_large;
    numbering.session_step = *step;
  }
  std::vector<std::uint64_t> pose_numbers;
  std::vector<std::uint64_t> feature_numbers;
  pose_numbers.reserve(poses.size());
  feature_numbers.reserve(features.size());
  for (const PoseId& id : poses) pose_numbers.push_back(numbering(id));
  for (const FeatureId& id : features) feature_numbers.push_back(numbering(id));
  if (meet(pose_numbers, feature_numbers)) {
    const auto offset = power_of_ten_above(largest_pose + last_session * numbering.session_step);
    if (!offset || *offset > kMost - largest_feature) return too_large;
    numbering.feature_offset = *offset;
  }
  return numbering;
}

}  // namespace mapjoin
