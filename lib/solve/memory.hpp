// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How much memory there is, and what a factor takes; too much is refused with a sentence before it is asked for.

#include <cstdint>
#include <mapjoin/model/error.hpp>
#include <mapjoin/solve/supernodes.hpp>
#include <string>

namespace mapjoin {

/// The physical memory of the machine (bytes).
std::int64_t machine_memory();

/// What the values of a factor take (bytes).
std::int64_t factor_bytes(const Supernodes& factor);

/// kTooLarge where `what` ("the covariances", say) takes more than `limit` bytes; with a limit of 0, more than the machine has.
Expected<void> check_memory(const std::string& what, std::int64_t bytes, std::int64_t limit);

}  // namespace mapjoin
