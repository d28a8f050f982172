// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/association/frames/feature_map.hpp>
#include <mapjoin/join/association/matching/point_tree.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/parallel/parallel.hpp>

namespace mapjoin {
namespace {

/// Number of nearest neighbours of a feature that triangles are made of.
constexpr std::size_t kNeighbours = 8;
/// The most triangles that one is compared with.
constexpr std::size_t kMostAlike = 256;
/// The quantile of the variances of triangles that sets the search radius in the tree; the few more uncertain ones find fewer.
constexpr double kUncertain = 0.95;

/// A feature with two of its neighbours, by their indices among its neighbours.
struct Triangle {
  std::uint32_t centre = 0;
  std::array<std::uint8_t, 2> ends{};
  Point<3> sides;      // from the centre to either end, and between the ends
  Point<3> variances;  // of the sides (m²)
};

/// All triangles of a map.
template <int Dim>
struct Triangles {
  std::vector<std::vector<std::size_t>> neighbours;  // by feature
  std::vector<Triangle> all;                         // feature by feature
  std::vector<std::size_t> begin;                    // the first of each feature's triangles, then the end

  /// With `both_ways` a triangle is listed twice in 3D, with its ends swapped: no orientation tells these apart.
  Triangles(const FeatureMap<Dim>& map, bool both_ways) {
    const PointTree<Dim> tree(map.features);
    for (std::size_t centre = 0; centre < map.features.size(); ++centre) {
      auto nearest = tree.nearest(map.features[centre], kNeighbours + 1);
      std::erase(nearest, centre);
      nearest.resize(std::min(nearest.size(), kNeighbours));
      neighbours.push_back(std::move(nearest));
      begin.push_back(all.size());
      add_around(map, centre, both_ways);
    }
    begin.push_back(all.size());
  }

 private:
  void add_around(const FeatureMap<Dim>& map, std::size_t centre, bool both_ways) {
    const auto& around = neighbours[centre];
    for (std::uint8_t x = 0; x < around.size(); ++x) {
      for (std::uint8_t y = 0; y < around.size(); ++y) {
        if (x == y || !(Dim == 2 ? is_left_turn(map, centre, around[x], around[y]) : both_ways || x < y)) continue;
        const auto side = [&](std::size_t a, std::size_t b) { return (map.features[a] - map.features[b]).norm(); };
        all.push_back({static_cast<std::uint32_t>(centre),
                       {x, y},
                       {side(centre, around[x]), side(centre, around[y]), side(around[x], around[y])},
                       {map.variance_of_distance(centre, around[x]), map.variance_of_distance(centre, around[y]),
                        map.variance_of_distance(around[x], around[y])}});
      }
    }
  }
  /// True if the ends go round the centre counter-clockwise in the plane.
  static bool is_left_turn(const FeatureMap<Dim>& map, std::size_t centre, std::size_t x, std::size_t y) {
    const Point<Dim> a = map.features[x] - map.features[centre];
    const Point<Dim> b = map.features[y] - map.features[centre];
    return a[0] * b[1] > a[1] * b[0];
  }
};

/// Two triangles that look alike, around one feature of the first map.
struct Alike {
  std::uint32_t centre = 0;                // in the second map
  std::array<std::uint8_t, 2> neighbours;  // each one in the first map times kNeighbours, plus one in the second
};

/// The most neighbours that triangles around two features agree on, as `Alike` has them: at least three, or none.
std::vector<Vertex> agreed(std::vector<Alike>::const_iterator begin, std::vector<Alike>::const_iterator end) {
  std::array<std::uint64_t, kNeighbours * kNeighbours> adjacent{};
  for (auto alike = begin; alike != end; ++alike) {
    const auto [a, b] = alike->neighbours;
    adjacent[a] |= std::uint64_t{1} << b;
    adjacent[b] |= std::uint64_t{1} << a;
  }
  std::vector<Edge> edges;  // those with a third vertex that is adjacent to both ends
  for (auto alike = begin; alike != end; ++alike) {
    const auto [a, b] = alike->neighbours;
    if ((adjacent[a] & adjacent[b]) != 0) edges.emplace_back(a, b);
  }
  return largest_clique(edges);
}

/// The kUncertain quantile of the largest variance of a side (m²).
double usual_variance(const std::vector<Triangle>& triangles) {
  if (triangles.empty()) return 0.0;
  std::vector<double> variances;
  for (const Triangle& t : triangles) variances.push_back(t.variances.maxCoeff());
  const auto most = variances.begin() + static_cast<std::ptrdiff_t>(kUncertain * static_cast<double>(variances.size() - 1));
  std::ranges::nth_element(variances, most);
  return *most;
}

}  // namespace

template <int Dim>
std::vector<Constellation> constellations_alike(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second,
                                                double confidence) {
  static_assert(kNeighbours * kNeighbours <= 64);
  const Triangles<Dim> of_first(first, false);
  const Triangles<Dim> of_second(second, true);
  const double gate = chi_squared_quantile(confidence, 3);
  const double variance = usual_variance(of_second.all);
  std::vector<Point<3>> sides;
  for (const Triangle& t : of_second.all) sides.push_back(t.sides);
  const PointTree<3> tree(sides);
  std::vector<std::vector<Constellation>> around(first.features.size());
  parallel_for(around.size(), [&](std::size_t centre) {
    std::vector<Alike> alike;
    for (std::size_t k = of_first.begin[centre]; k < of_first.begin[centre + 1]; ++k) {
      const Triangle& own = of_first.all[k];
      const double distance = std::sqrt(gate * (own.variances.maxCoeff() + variance));
      for (const std::size_t index : tree.some_within(own.sides, distance, kMostAlike)) {
        const Triangle& other = of_second.all[index];
        const Point<3> difference = own.sides - other.sides;
        if (difference.cwiseAbs2().cwiseQuotient(own.variances + other.variances).sum() > gate) continue;
        const auto pair = [&](int end) {
          return static_cast<std::uint8_t>(own.ends[static_cast<std::size_t>(end)] * kNeighbours +
                                           other.ends[static_cast<std::size_t>(end)]);
        };
        alike.push_back({other.centre, {pair(0), pair(1)}});
      }
    }
    std::ranges::stable_sort(alike, {}, &Alike::centre);
    for (auto begin = alike.cbegin(); begin != alike.cend();) {
      const auto end = std::find_if(begin, alike.cend(), [&](const Alike& a) { return a.centre != begin->centre; });
      if (const auto neighbours = agreed(begin, end); !neighbours.empty()) {
        Constellation& found = around[centre].emplace_back(Constellation{{centre, begin->centre}});
        for (const Vertex v : neighbours) {
          found.push_back({of_first.neighbours[centre][v / kNeighbours], of_second.neighbours[begin->centre][v % kNeighbours]});
        }
      }
      begin = end;
    }
  });
  std::vector<Constellation> all;
  for (auto& some : around) std::ranges::move(some, std::back_inserter(all));
  return all;
}

template std::vector<Constellation> constellations_alike(const FeatureMap<2>&, const FeatureMap<2>&, double);
template std::vector<Constellation> constellations_alike(const FeatureMap<3>&, const FeatureMap<3>&, double);

}  // namespace mapjoin
