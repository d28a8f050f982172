// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The fit of the map that a run makes of a log.

#include <mapjoin/join/run.hpp>

namespace mapjoin::testing {

template <int Dim>
GoodnessOfFit fit_of(const Log<Dim>& log) {
  return run(log, {}).value().fit;
}

}  // namespace mapjoin::testing
