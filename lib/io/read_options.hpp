// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Options of readers: how to take the content of a file, and what to leave out.

#include <cstdint>
#include <mapjoin/model/conventions.hpp>
#include <optional>

namespace mapjoin {

enum class LogFormat : std::uint8_t;

/// The treatment of an edge to a pose or feature that a file with vertices does not declare.
enum class Undeclared : std::uint8_t {
  kRefused,  ///< Bad input.
  kSkipped,  ///< Left out, and counted.
  kForeign,  ///< Between poses kept apart (Log::foreign), since another file may declare them; otherwise bad input.
  kToCome,   ///< Taken, since lines to come may declare it; what no edge names yet is left out for the same reason.
};

/// Options of readers; all that is left out is counted in Log::skipped.
struct ReadOptions {
  PoseError pose_error = PoseError::kPaper;                                 ///< g2o files only.
  RotationInformation rotation_information = RotationInformation::kVector;  ///< 3D g2o files only.
  bool repair_information = false;  ///< Takes the nearest semidefinite matrix for an asymmetric or indefinite one; counted.

  std::optional<LogFormat> from = {};   ///< Format of a log's file; nullopt: known by its content.
  bool skip_unknown = false;            ///< Leaves out lines with a tag that the format does not have.
  bool skip_self_edges = false;         ///< Leaves out edges from a pose to itself.
  bool identity_where_missing = false;  ///< Takes the identity for missing weights of an edge or observation.
  Undeclared undeclared = Undeclared::kRefused;

  /// True if the information matrices of a g2o file are to be turned into the conventions used inside.
  bool turns_information() const {
    return pose_error != PoseError::kPaper || rotation_information != RotationInformation::kVector;
  }
};

}  // namespace mapjoin
