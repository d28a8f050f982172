// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Points near a point, by a k-d tree.

#include <Eigen/Core>
#include <mapjoin/geometry/pose.hpp>
#include <memory>
#include <span>
#include <vector>

namespace mapjoin {

/// A k-d tree of points, which it copies.
template <int Dim>
class PointTree {
 public:
  explicit PointTree(std::span<const Point<Dim>> points);
  ~PointTree();

  /// The places of all points within a distance, as they are found.
  std::vector<std::size_t> within(const Point<Dim>& centre, double distance) const;
  /// The places of some points within a distance, as they are found; at most `most`.
  std::vector<std::size_t> some_within(const Point<Dim>& centre, double distance, std::size_t most) const;
  /// The places of the nearest points, the nearest first; all if there are fewer than `count`.
  std::vector<std::size_t> nearest(const Point<Dim>& centre, std::size_t count) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace mapjoin
