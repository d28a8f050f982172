// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What may be asked of the memory.

#include <cstdint>
#include <mapjoin/model/error.hpp>
#include <string>

namespace mapjoin {

/// The physical memory of the machine (bytes).
std::int64_t machine_memory();

/// kTooLarge where `what` ("the covariances", say) takes more than `limit` bytes; with a limit of 0, more than the machine has.
Expected<void> check_memory(const std::string& what, std::int64_t bytes, std::int64_t limit);

}  // namespace mapjoin
