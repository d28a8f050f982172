// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Limits on memory.

#include <cstdint>
#include <mapjoin/model/error.hpp>
#include <string>

namespace mapjoin {

/// The physical memory of the machine (bytes).
std::int64_t machine_memory();

/// Bytes as text, in megabytes; below 10 MB with three digits.
std::string in_megabytes(std::int64_t bytes);

/// kTooLarge if `what` ("the covariances", say) takes more than `limit` bytes or, with a limit of 0, more than the machine has.
Expected<void> check_memory(const std::string& what, std::int64_t bytes, std::int64_t limit);

}  // namespace mapjoin
