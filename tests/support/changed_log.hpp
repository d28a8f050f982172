// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Logs that differ by one closure or observation.

#include <cstddef>
#include <iterator>
#include <mapjoin/model/log.hpp>

namespace mapjoin::testing {

/// Shifts the measurement of a closure along x.
template <int Dim>
void spoil_closure(Log<Dim>& log, std::size_t closure, double metres) {
  log.graph.pose_factors[log.odometry().size() + closure].measured.translation[0] += metres;
}

/// Shifts an observation along x.
template <int Dim>
void spoil_observation(Log<Dim>& log, std::size_t observation, double metres) {
  log.graph.feature_factors[observation].measured[0] += metres;
}

template <int Dim>
Log<Dim> without_closure(Log<Dim> log, std::size_t closure) {
  auto& factors = log.graph.pose_factors;
  factors.erase(factors.begin() + std::ssize(log.odometry()) + static_cast<std::ptrdiff_t>(closure));
  return log;
}

template <int Dim>
Log<Dim> without_observation(Log<Dim> log, std::size_t observation) {
  auto& factors = log.graph.feature_factors;
  factors.erase(factors.begin() + static_cast<std::ptrdiff_t>(observation));
  return log;
}

}  // namespace mapjoin::testing
