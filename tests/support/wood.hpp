// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A drive through a wood, whose trees tell where a map lies.

#include <mapjoin/simulate/manhattan.hpp>

namespace mapjoin::testing {

/// A simulated world with a feature every few metres, at random offsets from a lattice.
template <int Dim>
Simulation<Dim> wood(std::uint64_t seed) {
  ManhattanOptions options;
  options.seed = seed;
  options.poses = Dim == 2 ? 300 : 120;
  options.side = Dim == 2 ? 15.0 : 10.0;
  options.range = Dim == 2 ? 5.0 : 6.0;
  options.feature_cell = Dim == 2 ? 2.5 : 4.0;
  options.feature_jitter = Dim == 2 ? 1.2 : 1.8;
  return simulate_manhattan<Dim>(options);
}

}  // namespace mapjoin::testing
