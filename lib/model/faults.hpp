// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What is wrong with the names, factors and fixed poses of a log or a set of maps, in words.

#include <fmt/format.h>

#include <mapjoin/model/error.hpp>
#include <mapjoin/model/factor.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/lists.hpp>
#include <string>
#include <vector>

namespace mapjoin {

/// Bad input if a pose or feature is named twice.
template <typename Index, typename Id>
Expected<void> check_names(const Table<Index, Id>& names) {
  const auto twice = repeated(names);
  return twice ? bad_input("it names " + to_string(*twice) + " twice") : Expected<void>();
}

/// The name of a pose or feature; its index if there is none.
template <typename Index, typename Id>
std::string name_of(const Table<Index, Id>& names, Index index) {
  return indices(names).contains(index) ? to_string(names[index]) : fmt::format("index {}", index.value);
}

/// The k-th factor of a kind, "pose factor 3, from pose 1 to pose 2, ", before what is wrong with it.
template <typename Factor, typename Targets>
std::string factor_in_words(const char* kind, std::size_t k, const Factor& factor, const PoseIds& poses,
                            const Targets& targets) {
  const std::string base = factor.base == kWorld ? "the World" : name_of(poses, factor.base);
  return fmt::format("{} {}, from {} to {}, ", kind, k, base, name_of(targets, factor.target));
}

/// Bad input unless the factors are of poses and features that are there, each of two different ones, and have numbers that
/// LogBuilder takes; a factor that a search has dropped passes, too.
template <typename Factor, typename Targets>
Expected<void> check_factors(const char* kind, const std::vector<Factor>& factors, const PoseIds& poses,
                             const Targets& targets) {
  InformationCheck check;
  for (std::size_t k = 0; k < factors.size(); ++k) {
    Factor factor = factors[k];
    if (factor.loss == Loss::dropped()) factor.loss = {};
    const auto wrong = [&](const std::string& why) {
      return bad_input(factor_in_words(kind, k, factor, poses, targets) + why);
    };
    const bool has_base = factor.base == kWorld || indices(poses).contains(factor.base);
    if (!has_base || !indices(targets).contains(factor.target)) return wrong("names a pose or feature that is not there");
    if constexpr (requires { factor.base == factor.target; }) {
      if (factor.base == factor.target) return wrong("leads from a pose to itself");
    }
    if (const auto of_numbers = fault(factor, check)) return wrong(*of_numbers);
  }
  return {};
}

/// Nothing but its fixing names the pose.
inline std::string fixed_without_pose(const PoseId& id) {
  return to_string(id) + " is fixed, but the log has no such pose (a feature is not fixed, but held by a prior)";
}

/// Neither the pose nor the other one, which is fixed, too, has a value.
inline std::string fixed_nowhere(const PoseId& id, const PoseId& other) {
  return fmt::format(
      "{} is fixed beside {}, but nothing says where: give it a value (in a g2o file, its vertex) or fix one of "
      "the two only",
      to_string(id), to_string(other));
}

}  // namespace mapjoin
