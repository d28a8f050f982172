// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
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

/// The index in a key: of a GTSAM symbol, the number below its letter; otherwise the key itself.
constexpr std::uint64_t kMostIndex = (std::uint64_t{1} << 56) - 1;
std::uint64_t index_in(std::uint64_t key) {
  return symbol_letter(key) == '\0' ? key : key & kMostIndex;
}

/// True if poses of different sessions have the same key.
bool do_keys_meet(const std::vector<PoseId>& poses) {
  const bool has_one = std::ranges::all_of(poses, [&](const PoseId& id) { return id.session == poses.front().session; });
  if (has_one) return false;
  std::vector<std::uint64_t> keys;
  for (const PoseId& id : poses) keys.push_back(id.key);
  std::ranges::sort(keys);
  return std::ranges::adjacent_find(keys) != keys.end();
}

}  // namespace

std::vector<std::string> in_words(const G2oNumbering& numbering) {
  std::vector<std::string> words;
  if (numbering.session_step > 0) {
    words.push_back(fmt::format("poses of session n are numbered from n times {} on", numbering.session_step));
  }
  if (numbering.feature_offset > 0) {
    words.push_back(fmt::format("features are numbered from {} on, apart from poses", numbering.feature_offset));
  }
  return words;
}

Expected<G2oNumbering> number_for_g2o(const std::vector<PoseId>& poses, const std::vector<FeatureId>& features) {
  const tl::unexpected<Error> too_large(Error{ErrorKind::kUsage,
                                              "a g2o file has one numbering of 64 bits, into which the keys of these poses and "
                                              "features do not fit; a map in .csv has room for them"});
  std::uint64_t largest_pose = 0;
  std::uint64_t largest_index = 0;
  std::uint32_t last_session = 0;
  for (const PoseId& id : poses) {
    largest_pose = std::max(largest_pose, id.key);
    largest_index = std::max(largest_index, index_in(id.key));
    last_session = std::max(last_session, id.session);
  }
  std::uint64_t largest_feature = 0;
  for (const FeatureId& id : features) largest_feature = std::max(largest_feature, id.key);

  G2oNumbering numbering;
  if (do_keys_meet(poses)) {
    const auto step = power_of_ten_above(largest_index);
    const std::uint64_t most = largest_index < largest_pose ? kMostIndex : kMost;
    if (!step || *step > (most - largest_index) / last_session) return too_large;
    numbering.session_step = *step;
  }
  std::vector<std::uint64_t> taken;
  taken.reserve(poses.size());
  for (const PoseId& id : poses) taken.push_back(numbering(id));
  std::ranges::sort(taken);
  if (std::ranges::any_of(features, [&](const FeatureId& id) { return std::ranges::binary_search(taken, id.key); })) {
    const auto offset = power_of_ten_above(largest_pose + last_session * numbering.session_step);
    if (!offset || *offset > kMost - largest_feature) return too_large;
    numbering.feature_offset = *offset;
  }
  return numbering;
}

}  // namespace mapjoin
