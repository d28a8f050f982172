// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdint>
#include <mapjoin/join/association/matching/point_tree.hpp>
#include <nanoflann.hpp>

namespace mapjoin {
namespace {

/// A set of results for nanoflann that ends the search once it has `most` points.
struct Some {
  double squared_distance;
  std::size_t most;
  std::vector<std::size_t> places;

  bool addPoint(double squared, Eigen::Index place) {
    if (squared < squared_distance) places.push_back(static_cast<std::size_t>(place));
    return places.size() < most;
  }
  bool full() const { return true; }
  double worstDist() const { return squared_distance; }
};

}  // namespace

template <int Dim>
struct PointTree<Dim>::Tree {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Dim>;
  using Adaptor = nanoflann::KDTreeEigenMatrixAdaptor<Rows, Dim>;

  static Rows rows_of(std::span<const Point<Dim>> points) {
    Rows rows(static_cast<Eigen::Index>(points.size()), Dim);
    for (std::size_t k = 0; k < points.size(); ++k) rows.row(static_cast<Eigen::Index>(k)) = points[k].transpose();
    return rows;
  }
  explicit Tree(std::span<const Point<Dim>> points) : rows(rows_of(points)), adaptor(Dim, rows) {}

  Rows rows;
  Adaptor adaptor;
};

template <int Dim>
PointTree<Dim>::PointTree(std::span<const Point<Dim>> points) {
  if (!points.empty()) tree_ = std::make_unique<Tree>(points);
}

template <int Dim>
PointTree<Dim>::~PointTree() = default;

template <int Dim>
std::vector<std::size_t> PointTree<Dim>::within(const Point<Dim>& centre, double distance) const {
  std::vector<std::size_t> places;
  if (!tree_) return places;
  std::vector<std::pair<Eigen::Index, double>> found;
  nanoflann::SearchParams in_any_order;
  in_any_order.sorted = false;
  tree_->adaptor.index->radiusSearch(centre.data(), distance * distance, found, in_any_order);
  for (const auto& near : found) places.push_back(static_cast<std::size_t>(near.first));
  return places;
}

template <int Dim>
std::vector<std::size_t> PointTree<Dim>::some_within(const Point<Dim>& centre, double distance, std::size_t most) const {
  Some found{distance * distance, most, {}};
  if (tree_) tree_->adaptor.index->findNeighbors(found, centre.data(), nanoflann::SearchParams());
  return std::move(found.places);
}

template <int Dim>
std::vector<std::size_t> PointTree<Dim>::nearest(const Point<Dim>& centre, std::size_t count) const {
  if (!tree_) return {};
  count = std::min(count, static_cast<std::size_t>(tree_->rows.rows()));
  std::vector<Eigen::Index> places(count);
  std::vector<double> squared_distances(count);
  const std::size_t found = tree_->adaptor.index->knnSearch(centre.data(), count, places.data(), squared_distances.data());
  return {places.begin(), places.begin() + static_cast<std::ptrdiff_t>(found)};
}

template class PointTree<2>;
template class PointTree<3>;

}  // namespace mapjoin
