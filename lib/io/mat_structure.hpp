// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The structure of a MAT file, checked before matio reads it: matio passes over a damaged or shortened stream in silence.

#include <cstddef>
#include <mapjoin/io/file_bytes.hpp>
#include <mapjoin/model/error.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// Whether `bytes` begin as a MAT file does that is of version 5 or later, be it one that is refused.
bool is_mat_file(std::string_view bytes);

/// The MAT file of version 5 (which 6 and 7 share) with its compressed variables inflated, and without those that are no
/// matrices: matio believes the counts in cells and structures. Errors, beginning with `file`: one
/// of version 7.3 or of a big-endian machine, or none; a compressed stream that is damaged; variables that do not fill the
/// file, or parts that do not fill them; flags or dimensions of another type, or of no whole numbers; a matrix of doubles that
/// has not as many numbers as its dimensions say; kTooLarge beyond `most` bytes.
Expected<std::string> checked_and_inflated(std::string_view bytes, const std::string& file,
                                           std::size_t most = kMostUnpackedBytes);

}  // namespace mapjoin
