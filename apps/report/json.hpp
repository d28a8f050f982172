// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// JSON as the command writes it: keys in their order; enums as their words; missing and non-finite values as null.

#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/ids.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace nlohmann {

template <typename T>
struct adl_serializer<std::optional<T>> {
  static void to_json(ordered_json& json, const std::optional<T>& value) { json = value ? ordered_json(*value) : nullptr; }
};

template <mapjoin::NamedEnum Enum>
struct adl_serializer<Enum> {
  static void to_json(ordered_json& json, Enum value) { json = mapjoin::to_string(value); }
};

}  // namespace nlohmann

namespace mapjoin {

inline void to_json(nlohmann::ordered_json& json, const PoseId& id) {
  json = {{"session", id.session}, {"pose", id.key}};
}
inline void to_json(nlohmann::ordered_json& json, const FeatureId& id) {
  json = {{"feature", id.key}};
}

namespace apps {

using Json = nlohmann::ordered_json;

/// The object if its values are known; otherwise null under each of its keys.
inline Json if_known(bool known, Json object) {
  for (auto& value : object) {
    if (!known) value = nullptr;
  }
  return object;
}

}  // namespace apps
}  // namespace mapjoin
