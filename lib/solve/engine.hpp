// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The engines that factorise sparse normal equations.

#include <array>
#include <cstdint>
#include <string>

namespace mapjoin {

enum class Engine : std::uint8_t {
  kFronts,   ///< mapjoin's tree of fronts, on all threads.
  kCholmod,  ///< SuiteSparse's CHOLMOD on one thread: an independent factorisation to compare with.
};

inline constexpr std::array kEngines{Engine::kFronts, Engine::kCholmod};

/// "fronts" or "cholmod", as in the report.
inline std::string to_string(Engine engine) {
  return engine == Engine::kFronts ? "fronts" : "cholmod";
}

}  // namespace mapjoin
