// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the reader of a log must be told beyond the file, and what it gives: a log of either dimension.

#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/log.hpp>
#include <variant>

namespace mapjoin {

/// How to take a file's numbers.
struct ReadOptions {
  PoseError pose_error = PoseError::kPaper;                                 ///< g2o files only.
  RotationInformation rotation_information = RotationInformation::kVector;  ///< 3D g2o files only.
  bool repair_information = false;  ///< Indefinite matrices become their nearest semidefinite one, and are counted.
};

/// The file decides which.
using AnyLog = std::variant<Log<2>, Log<3>>;

}  // namespace mapjoin
