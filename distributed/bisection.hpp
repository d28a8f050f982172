// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Space cut into one region for each rank, by recursive coordinate bisection (Berger & Bokhari, 1987), where regions share
// little.

#include <Eigen/Geometry>
#include <mapjoin/distributed/communicator.hpp>
#include <mapjoin/geometry/pose.hpp>
#include <vector>

namespace mapjoin::distributed {

/// Unknowns, and the box around the points from which they are seen: a cut through it makes them shared.
template <int Dim>
struct Span {
  Eigen::AlignedBox<double, Dim> box;
  int unknowns = 0;
};

/// Regions with as many points as each other, but for a few per cent, which are left for the sake of fewer shared unknowns. It
/// takes no more than counts from the ranks.
template <int Dim>
class Bisection {
 public:
  /// `points` and `spans` are those of this rank.
  Bisection(const Communicator& comm, std::vector<Point<Dim>> points, std::vector<Span<Dim>> spans);

  /// The region that a point lies in, from 0 on.
  std::size_t region_of(const Point<Dim>& point) const;

 private:
  /// Cuts across its longest side what holds the points of regions [first, last).
  void cut(const Communicator& comm, std::vector<Point<Dim>> points, std::vector<Span<Dim>> spans, std::size_t first,
           std::size_t last);

  /// What lies below goes on with the next cut, or to region `first` where there is one region only; else with cut `above`.
  struct Cut {
    std::size_t first = 0;
    std::size_t regions = 1;
    int axis = 0;
    double at = 0.0;
    std::size_t above = 0;
  };
  std::vector<Cut> cuts_;
};

}  // namespace mapjoin::distributed
