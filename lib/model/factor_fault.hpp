// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What may be wrong with the numbers of a factor that was made in memory.

#include <mapjoin/model/factor.hpp>
#include <mapjoin/model/information.hpp>
#include <optional>
#include <string>

namespace mapjoin {

template <int Dim>
bool has_sound_lever(const PoseFactor<Dim>& factor) {
  return is_valid(factor.lever);
}
template <int Dim>
bool has_sound_lever(const FeatureFactor<Dim>&) {
  return true;
}

/// What is wrong with a factor, "has … that …"; nothing where its measurement and lever are finite, and its information matrix
/// passes `check`, which may make it symmetric.
template <typename Factor>
std::optional<std::string> fault(Factor& factor, InformationCheck& check) {
  if (!is_valid(factor.measured)) return "has a measurement that is not finite, or no rotation";
  if (!has_sound_lever(factor)) return "has a lever that is not finite";
  const auto of_information = check.fault(factor.information);
  return of_information ? std::optional("has an information matrix that " + *of_information) : std::nullopt;
}

}  // namespace mapjoin
