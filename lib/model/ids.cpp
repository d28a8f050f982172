// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <mapjoin/model/ids.hpp>

namespace mapjoin {

std::string to_string(const PoseId& id) {
  return id.session == 0 ? fmt::format("pose {}", id.key) : fmt::format("pose {} of session {}", id.key, id.session);
}

std::string to_string(const FeatureId& id) {
  return fmt::format("feature {}", id.key);
}

}  // namespace mapjoin
