// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Small random logs with their truth: a robot drives rounds among point features, with noise and a few loop closures.

#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/model/values.hpp>
#include <tests/support/random.hpp>
#include <vector>

namespace mapjoin::testing {

struct WorldOptions {
  int poses = 40;  ///< Number of poses in each session.
  int features = 25;
  int closures = 3;  ///< Number of closures within each session, in alternating directions.
  int sessions = 1;  ///< Number of sessions, tied to each other by features only.
  double range = 4.0;
  double noise = 0.02;             ///< Largest error of any coordinate (m, rad).
  bool reversed_odometry = false;  ///< Every third step is stored against its direction.
  unsigned seed = 1;
};

template <int Dim>
struct SmallWorld {
  Log<Dim> log;
  Values<Dim> truth;  ///< The truth by the indices of the log; pose 0 is the origin.
};

/// A pose with an error of at most `noise` in each of its coordinates.
template <int Dim>
Pose<Dim> noisy(const Pose<Dim>& pose, double noise, Random& random);

/// Adds the edges and observations of one session, whose poses are named 0, 1, … .
template <int Dim>
void record(std::uint32_t session, const std::vector<Pose<Dim>>& path, const std::vector<Point<Dim>>& features,
            const WorldOptions& options, Random& random, LogBuilder<Dim>& builder);

template <int Dim>
SmallWorld<Dim> small_world(const WorldOptions& options = {});

/// The largest difference of a pose or feature between two states (m, rad); NaN if their sizes differ.
template <int Dim>
double largest_difference(const Values<Dim>& a, const Values<Dim>& b);

}  // namespace mapjoin::testing
