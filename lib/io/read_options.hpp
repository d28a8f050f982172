// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How the reader of a file is to take what it says, and what it is to leave out.

#include <cstdint>
#include <mapjoin/model/conventions.hpp>
#include <optional>

namespace mapjoin {

enum class LogFormat : std::uint8_t;

/// What becomes of an edge to a pose or feature that a file with vertices does not declare.
enum class Undeclared : std::uint8_t {
  kRefused,  ///< It is bad input.
  kSkipped,  ///< It is left out, and counted.
  kForeign,  ///< Between poses it is kept apart (Log::foreign), for another file may declare them; else it is bad input.
};

/// Whatever is left out is counted in Log::skipped.
struct ReadOptions {
  PoseError pose_error = PoseError::kPaper;                                 ///< g2o files only.
  RotationInformation rotation_information = RotationInformation::kVector;  ///< 3D g2o files only.
  bool repair_information = false;  ///< Indefinite matrices become their nearest semidefinite one, and are counted.

  std::optional<LogFormat> from = {};   ///< Of a log's file; nothing: known by its content.
  bool skip_unknown = false;            ///< Leaves out lines whose tag the format does not have.
  bool skip_self_edges = false;         ///< Leaves out edges from a pose to itself.
  bool identity_where_missing = false;  ///< Takes the identity for the weights of an edge or observation without any.
  Undeclared undeclared = Undeclared::kRefused;
};

}  // namespace mapjoin
