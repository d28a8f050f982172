// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/solve/minimise_options.hpp>

namespace mapjoin {

std::vector<std::string> MinimiseOptions::validate() const {
  std::vector<std::string> violations;
  if (max_iterations < 1) violations.emplace_back("the number of iterations must be at least 1");
  if (!(relative_chi2 >= 0.0)) violations.emplace_back("the relative decrease of chi2 to stop at must not be negative");
  if (!(step_metres >= 0.0)) violations.emplace_back("the step in metres to stop at must not be negative");
  if (!(step_radians >= 0.0)) violations.emplace_back("the step in radians to stop at must not be negative");
  return violations;
}

std::string to_string(MinimiseStatus status) {
  switch (status) {
    case MinimiseStatus::kConverged:
      return "converged";
    case MinimiseStatus::kMaxIterations:
      return "max_iterations";
    case MinimiseStatus::kNoProgress:
      return "no_progress";
    case MinimiseStatus::kSingular:
      return "singular";
    case MinimiseStatus::kInterrupted:
      return "interrupted";
  }
  return "unknown";
}

std::string to_string(Method method) {
  switch (method) {
    case Method::kGaussNewton:
      return "gn";
    case Method::kDogleg:
      return "dogleg";
    case Method::kLevenbergMarquardt:
      return "lm";
  }
  return "unknown";
}

}  // namespace mapjoin
