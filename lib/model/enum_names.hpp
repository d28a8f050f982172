// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Names of enum values, one table for each enum: options, reports, documents and tests use it.
//
// The table stands beside its enum, as a function found by argument-dependent lookup:
//
//   constexpr auto enum_names(Method) {
//     return std::to_array<EnumName<Method>>({{Method::kDogleg, "dogleg"}, {Method::kGaussNewton, "gn"}});
//   }

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

namespace mapjoin {

/// A value of an enum and its name. Help lists them in the order of the table.
template <typename Enum>
struct EnumName {
  Enum value;
  std::string_view name;
};

template <typename Enum>
concept NamedEnum = requires(Enum value) {
  enum_names(value).front().name;
};

/// The name of the value; "unknown" if the table does not have it.
template <NamedEnum Enum>
std::string to_string(Enum value) {
  const auto names = enum_names(value);
  const auto found = std::find_if(names.begin(), names.end(), [&](const auto& entry) { return entry.value == value; });
  return found == names.end() ? "unknown" : std::string(found->name);
}

}  // namespace mapjoin
