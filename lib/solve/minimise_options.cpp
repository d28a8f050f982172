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

}  // namespace mapjoin
