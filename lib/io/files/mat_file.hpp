// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// MATLAB files of version 5: matrices read from them, with everything checked, and written to them.

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

/// True if `bytes` begin as a MAT file of version 5 or later, including those that readers refuse.
bool is_mat_file(std::string_view bytes);

/// The MAT file of version 5 (which 6 and 7 share) with its compressed variables inflated, and without variables that are not
/// matrices of numbers or characters. Errors, beginning with `file`: not a MAT file, or one of version 7.3 or of a big-endian
/// machine; a damaged compressed stream; variables that do not fill the file, or parts that do not fill a variable; flags or
/// dimensions of a wrong type or size; a matrix of doubles with more or fewer numbers than its dimensions say; kTooLarge beyond
/// `most` bytes.
Expected<std::string> checked_and_inflated(std::string_view bytes, const std::string& file,
                                           std::size_t most = kMostUnpackedBytes);

/// Variables by their name.
using MatVariables = std::map<std::string, Eigen::MatrixXd, std::less<>>;

/// The variables among `names` in the MAT file with the content `bytes`; others are not read. A sparse matrix becomes dense and
/// may have up to 10000 rows and columns, and no more than the file has room for numbers.
/// Errors, beginning with `file`: those of checked_and_inflated(); a variable that is not a real matrix of doubles; kTooLarge
/// for a sparse one beyond these bounds.
Expected<MatVariables> read_mat(std::string_view bytes, const std::string& file, std::initializer_list<std::string_view> names);

/// A variable to be written, by its name.
using MatVariable = std::pair<std::string, Eigen::MatrixXd>;

/// The bytes of a MAT file with these variables, in their order; the same bytes on every machine and at any time. kTooLarge,
/// beginning with `file`, if a variable takes 2 GiB or more, a size that the format has no number for.
Expected<std::string> mat_bytes(const std::vector<MatVariable>& variables, const std::string& file);

/// The end of the ids that doubles hold: every integer below it is a double to which no other integer rounds.
inline constexpr double kDoubleIdEnd = 9007199254740992.0;  // 2⁵³

/// The id that equals `value`; nullopt unless this is an integer from 0 to below kDoubleIdEnd.
inline std::optional<std::uint64_t> id_of(double value) {
  if (!(value >= 0.0 && value < kDoubleIdEnd) || value != std::floor(value)) return std::nullopt;
  return static_cast<std::uint64_t>(value);
}

}  // namespace mapjoin
