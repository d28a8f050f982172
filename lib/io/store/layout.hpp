// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The names of the numbers and arrays of a log in a store.

#include <map>
#include <mapjoin/io/store/contents.hpp>
#include <string>
#include <string_view>

namespace mapjoin::store {

/// Hands every array to `visit`, with its name in the file.
template <typename Log, typename Segments, typename Visit>
void visit_arrays(Log& log, Segments&& segments, const Visit& visit) {
  visit("poses", log.poses);
  visit("features", log.features);
  visit("pose_factors", log.graph.pose_factors);
  visit("feature_factors", log.graph.feature_factors);
  visit("fixed", log.graph.fixed);
  visit("stamps_ns", log.stamps_ns);
  visit("initial_poses", log.initial.poses);
  visit("initial_features", log.initial.features);
  visit("segments", segments);
}

/// Hands every single number to `visit`, with its name in the file.
template <typename Log, typename Visit>
void visit_numbers(Log& log, const Visit& visit) {
  visit("unassociated", log.unassociated);
  visit("pose_error", log.conventions.pose_error);
  visit("rotation_information", log.conventions.rotation_information);
  visit("covariance", log.conventions.covariance);
  visit("repaired_informations", log.conventions.repairs.indefinite);
  visit("symmetrised_matrices", log.conventions.repairs.symmetrised);
  visit("largest_asymmetry", log.conventions.repairs.largest_asymmetry);
  visit("missing_informations", log.conventions.repairs.missing);
}

inline bool is_of_factors(std::string_view array) {
  return array == "pose_factors" || array == "feature_factors";
}

using Info = std::map<std::string, std::string>;

/// The key in `info` of the portion, "2/4", of a store that has not all factors of its log.
inline constexpr const char* kPortion = "portion";
/// The key in `info` of the share, "2/4", of a store that has not all local maps of its log.
inline constexpr const char* kShare = "part";
/// The key in `info` of what the ids of features mean in several inputs, "shared"; missing where nobody said it.
inline constexpr const char* kFeatures = "features";
inline constexpr const char* kSharedFeatures = "shared";
/// The prefix of the keys that count what the reader of the log left out: "skipped self-edges".
inline constexpr std::string_view kSkipped = "skipped ";
/// The prefix of the keys of the factors on standard deviations that are not 1: "inflated closure".
inline constexpr std::string_view kInflated = "inflated ";

Expected<Info> read_info(Database& database);

}  // namespace mapjoin::store
