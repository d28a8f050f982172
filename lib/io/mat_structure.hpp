// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The structure of a MAT file, checked before matio reads it: matio passes over a damaged or shortened stream in silence.

#include <optional>
#include <string>
#include <string_view>

namespace mapjoin {

/// Whether `bytes` begin as a little-endian MAT file of version 5 (which 6 and 7 share) does.
bool is_mat_file(std::string_view bytes);

/// The MAT file with its compressed variables inflated. Empty where a compressed stream is damaged, the variables do not fill
/// the file or their parts do not fill them, or where a matrix of doubles has not as many numbers as its dimensions say.
std::optional<std::string> checked_and_inflated(std::string_view bytes);

}  // namespace mapjoin
