// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The engines that factorise sparse normal equations.

#include <cstdint>
#include <mapjoin/model/enum_names.hpp>

namespace mapjoin {

enum class Engine : std::uint8_t {
  kFronts,   ///< mapjoin's tree of fronts, on all threads.
  kCholmod,  ///< SuiteSparse's CHOLMOD on one thread: an independent factorisation to compare with.
};

constexpr auto enum_names(Engine) {
  return std::to_array<EnumName<Engine>>({{Engine::kFronts, "fronts"}, {Engine::kCholmod, "cholmod"}});
}

}  // namespace mapjoin
