// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// All values of an enum, from its table of names.

#include <mapjoin/model/enum_names.hpp>
#include <vector>

namespace mapjoin::testing {

template <NamedEnum Enum>
std::vector<Enum> every() {
  std::vector<Enum> values;
  for (const auto& entry : enum_names(Enum())) values.push_back(entry.value);
  return values;
}

}  // namespace mapjoin::testing
