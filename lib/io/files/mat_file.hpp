// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// MATLAB files of version 5: matrices out of them, with everything checked, and matrices into them.

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace mapjoin {

/// Whether `bytes` begin as a MAT file does that is of version 5 or later, be it one that is refused.
bool is_mat_file(std::string_view bytes);

/// The MAT file of version 5 (which 6 and 7 share) with its compressed variables inflated, and without those that are no
/// matrices of numbers or characters. Errors, beginning with `file`: one of version 7.3 or of a big-endian machine, or none; a
/// compressed stream that is damaged; variables that do not fill the file, or parts that do not fill them; flags or dimensions
/// of another type, or of no whole numbers; a matrix of doubles that has not as many numbers as its dimensions say; kTooLarge
/// beyond `most` bytes.
Expected<std::string> checked_and_inflated(std::string_view bytes, const std::string& file,
                                           std::size_t most = kMostUnpackedBytes);

/// Variables by their name.
using MatVariables = std::map<std::string, Eigen::MatrixXd, std::less<>>;

/// Those of `names` that the MAT file with the content `bytes` holds; other variables are not read. A sparse matrix is given
/// dense and may have up to 10000 rows and columns, and no more than numbers have room in the file.
/// Errors, beginning with `file`: not such a MAT file, or a damaged one; a variable that is not a real matrix of doubles, or
/// that is larger than a file of this size can hold.
Expected<MatVariables> read_mat(std::string_view bytes, const std::string& file, std::initializer_list<std::string_view> names);

/// The bytes of a MAT file with these variables, in their order; the same bytes on every machine and at any time. Throws
/// std::length_error where one takes 2 GiB or more, which the format has no number for.
std::string mat_bytes(const std::vector<std::pair<std::string, Eigen::MatrixXd>>& variables);

/// Ids end before it: every integer below is a double, and no other integer rounds to it.
inline constexpr double kDoubleIdEnd = 9007199254740992.0;  // 2⁵³

/// The id that `value` is, or nothing.
inline std::optional<std::uint64_t> id_of(double value) {
  if (!(value >= 0.0 && value < kDoubleIdEnd) || value != std::floor(value)) return std::nullopt;
  return static_cast<std::uint64_t>(value);
}

}  // namespace mapjoin
