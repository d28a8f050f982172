// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Matrices out of MATLAB files, with every size checked before memory is asked for.

#include <Eigen/Core>
#include <initializer_list>
#include <map>
#include <mapjoin/model/error.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// Variables by their name.
using MatVariables = std::map<std::string, Eigen::MatrixXd, std::less<>>;

/// Those of `names` that the MAT file with the content `bytes` holds; other variables are not read. A sparse matrix is given
/// dense and may have up to 10000 rows and columns, and no more than numbers have room in the file.
/// Errors, beginning with `file`: not such a MAT file, or a damaged one; a variable that is not a real matrix of doubles, or
/// that is larger than a file of this size can hold.
Expected<MatVariables> read_mat(std::string_view bytes, const std::string& file, std::initializer_list<std::string_view> names);

}  // namespace mapjoin
