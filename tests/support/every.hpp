// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Every value of an enum, as its table of words has them.

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
