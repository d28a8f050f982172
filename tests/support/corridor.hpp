// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// An endless corridor, map by map, whose maps all cost the same to join.

#include <malloc.h>

#include <mapjoin/join/incremental/submap_update.hpp>
#include <random>

namespace mapjoin::testing {

/// Local maps of one step of 1 m straight ahead. Features lie at the walls, two for each metre: each map sees four, two of
/// which the next one sees, too. Every hundredth map ends with a closure from the pose 20 m before. Every tenth pose has a
/// prior, so that nothing drifts, however long the corridor.
class Corridor {
 public:
  static constexpr double kSigma = 0.01;  ///< Stated standard deviation of every coordinate (m, rad).
  /// True standard deviation: so small that no closure demands a join of all by chance.
  static constexpr double kError = 0.5 * kSigma;

  SubmapUpdate<2> next() {
    SubmapUpdate<2> update;
    update.poses = {{0, next_}, {0, next_ + 1}};
    update.segments = {{0, 1, true}};
    LocalMap<2> map{0, {1}, {}, {noisy(1.0)}, {}, information<11>()};
    for (std::uint64_t f = 0; f < 4; ++f) {
      update.features.push_back({2 * next_ + f});
      map.features.emplace_back(f);
      map.feature_estimates.push_back(Point<2>(static_cast<double>(f / 2), f % 2 == 0 ? 3.0 : -3.0) + noise<2>());
    }
    update.graph.submaps.push_back(std::move(map));
    if (next_ % 100 == 99) {
      update.poses.push_back({0, next_ - 19});
      update.graph.pose_factors.push_back({2, 1, noisy(20.0), information<3>()});
    }
    if (next_ % 10 == 0) {
      update.graph.pose_factors.push_back({kWorld, 0, noisy(static_cast<double>(next_)), information<3>()});
    }
    ++next_;
    return update;
  }

 private:
  template <int Rows>
  Vector<Rows> noise() {
    Vector<Rows> errors;
    for (double& error : errors) error = kError * normal_(engine_);
    return errors;
  }
  template <int Rows>
  static Matrix<Rows> information() {
    return Matrix<Rows>::Identity() / (kSigma * kSigma);
  }
  Pose<2> noisy(double ahead) { return retract(Pose<2>{Point<2>(ahead, 0.0), {}}, PoseVector<2>(noise<3>())); }

  std::mt19937 engine_{1};
  std::normal_distribution<double> normal_;
  std::uint64_t next_ = 0;
};

/// The heap memory of this process in use (bytes).
inline double bytes_in_use() {
  const auto used = mallinfo2();
  return static_cast<double>(used.uordblks + used.hblkhd);
}

}  // namespace mapjoin::testing
