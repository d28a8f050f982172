// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// MATLAB files out of matrices: version 5, not compressed.

#include <Eigen/Core>
#include <mapjoin/model/error.hpp>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin {

/// The bytes of a MAT file with these variables, in their order; the same bytes on every machine and at any time. Throws
/// std::length_error where one takes 2 GiB or more, which the format has no number for.
std::string mat_bytes(const std::vector<std::pair<std::string, Eigen::MatrixXd>>& variables);

}  // namespace mapjoin
