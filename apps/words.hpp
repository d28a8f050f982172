// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The words that report, summary and options have for conventions.

#include <mapjoin/model/conventions.hpp>

namespace mapjoin::apps {

inline const char* word(PoseError error) {
  return error == PoseError::kPaper ? "paper" : "g2o";
}
inline const char* word(RotationInformation information) {
  return information == RotationInformation::kVector ? "vector" : "quaternion";
}
inline const char* word(Covariance covariance) {
  return covariance == Covariance::kOriginal ? "original" : "identity";
}

}  // namespace mapjoin::apps
