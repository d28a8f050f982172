// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Maps of features in frames of their own, with their truth: robots drive through a world and see the features nearby.

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <mapjoin/join/association/frames/feature_map.hpp>
#include <mapjoin/join/association/matching/neighbour_density.hpp>
#include <mapjoin/join/association/matching/sighting_chance.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <utility>
#include <vector>

namespace mapjoin::testing {

enum class Layout { kRandom, kJittered, kLattice, kBlocks };

struct FeatureWorldOptions {
  Layout layout = Layout::kRandom;
  double side = 40.0;    ///< Side of the square or cube (m).
  double spacing = 3.0;  ///< Side of a cell that holds one feature on average (m).
  double range = 8.0;    ///< Range of the sensor (m).
  double noise = 0.05;   ///< Standard deviation of a feature's coordinates (m).
  double drift = 0.02;   ///< Standard deviation of a step along each axis (m).
  double turn = 0.002;   ///< Standard deviation of a step's rotation about each axis (rad).
};

/// The places of all features of a world.
template <int Dim>
std::vector<Point<Dim>> feature_world(const FeatureWorldOptions& options, RandomStream& random) {
  const auto cells = static_cast<int>(options.side / options.spacing);
  constexpr int kBlock = 4;  // side of a block (cells)
  const auto uniform = [&] { return random.uniform(-0.5, 0.5); };
  std::vector<Point<Dim>> block;  // offsets (cells) that every block repeats
  std::vector<Point<Dim>> features;
  const int count = static_cast<int>(std::pow(cells, Dim));
  for (int k = 0; k < count; ++k) {
    Point<Dim> cell;
    int in_block = 0;
    for (int i = 0, rest = k; i < Dim; ++i, rest /= cells) {
      cell[i] = rest % cells + 0.5;
      in_block = in_block * kBlock + (rest % cells) % kBlock;
    }
    Point<Dim> offset = Point<Dim>::Zero();
    for (double& o : offset) o = uniform();
    switch (options.layout) {
      case Layout::kRandom:
        for (int i = 0; i < Dim; ++i) cell[i] = random.uniform(0.0, cells);
        offset.setZero();
        break;
      case Layout::kJittered:
        offset *= 0.3;
        break;
      case Layout::kLattice:
        offset.setZero();
        break;
      case Layout::kBlocks:
        while (static_cast<int>(block.size()) <= in_block) {
          Point<Dim>& next = block.emplace_back();
          for (double& o : next) o = uniform();
        }
        offset = block[static_cast<std::size_t>(in_block)];
        break;
    }
    features.push_back(options.spacing * (cell + offset));
  }
  return features;
}

/// The map that a drive along a path makes of a world, in the frame of its first pose, with its truth.
template <int Dim>
struct DrivenMap {
  FeatureMap<Dim> map;
  std::vector<std::size_t> truth;  ///< The feature of the world for each feature of the map.
  Pose<Dim> frame;                 ///< The frame of the map in the world.
};

template <int Dim>
DrivenMap<Dim> driven_map(const std::vector<Point<Dim>>& world, const std::vector<Point<Dim>>& path,
                          const FeatureWorldOptions& options, RandomStream& random) {
  constexpr int kRot = kRotationDof<Dim>;
  DrivenMap<Dim> driven;
  RotationVector<Dim> turn;
  for (double& t : turn) t = 2.0 * random.normal();
  driven.frame = {path.front(), Rotation<Dim>::exp(turn)};
  const Pose<Dim> world_in_map = inverse(driven.frame);
  for (const auto& p : path) driven.map.poses.push_back(transform(world_in_map, p));
  std::vector<std::size_t> seen_from;
  for (std::size_t f = 0; f < world.size(); ++f) {
    const auto nearest = std::ranges::min_element(path, {}, [&](const auto& p) { return (p - world[f]).squaredNorm(); });
    if ((*nearest - world[f]).norm() > options.range) continue;
    driven.truth.push_back(f);
    driven.map.features.push_back(transform(world_in_map, world[f]));
    seen_from.push_back(static_cast<std::size_t>(nearest - path.begin()));
  }
  // The error of a step moves and turns all features seen after it.
  const auto rows = static_cast<Eigen::Index>(driven.truth.size()) * Dim;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(path.size()) * (Dim + kRot));
  for (std::size_t f = 0; f < driven.truth.size(); ++f) {
    for (std::size_t k = 1; k <= seen_from[f]; ++k) {
      const Point<Dim> arm = driven.map.features[f] - driven.map.poses[k];
      auto J_step =
          J.template block<Dim, Dim + kRot>(static_cast<Eigen::Index>(f) * Dim, static_cast<Eigen::Index>(k) * (Dim + kRot));
      J_step.template leftCols<Dim>() = options.drift * PointMatrix<Dim>::Identity();
      for (int axis = 0; axis < kRot; ++axis) {
        RotationVector<Dim> small = RotationVector<Dim>::Zero();
        small[axis] = 1e-6;
        J_step.col(Dim + axis) = options.turn * 1e6 * (Rotation<Dim>::exp(small).matrix() * arm - arm);
      }
    }
  }
  driven.map.covariance = J * J.transpose();
  driven.map.covariance.diagonal().array() += options.noise * options.noise;
  Eigen::VectorXd error(rows);
  for (double& e : error) e = random.normal();
  error = (driven.map.covariance.llt().matrixL() * error).eval();
  for (std::size_t f = 0; f < driven.truth.size(); ++f) {
    driven.map.features[f] += error.segment<Dim>(static_cast<Eigen::Index>(f) * Dim);
  }
  return driven;
}

/// A path to and fro in lanes along the first axis, the lanes `apart` metres apart along the second, in steps of `step` metres.
template <int Dim>
std::vector<Point<Dim>> lanes(const Point<Dim>& corner, double width, double depth, double apart, double step = 1.0) {
  std::vector<Point<Dim>> path;
  bool is_back = false;
  for (double y = 0.0; y <= depth; y += apart, is_back = !is_back) {
    for (double x = 0.0; x <= width; x += step) {
      Point<Dim> p = corner;
      p[0] += is_back ? width - x : x;
      p[1] += y;
      path.push_back(p);
    }
  }
  return path;
}

/// The density of the features that lie within `range` of each pose of a map.
template <int Dim>
NeighbourDensity<Dim> density_of(const DrivenMap<Dim>& driven, double range) {
  std::vector<std::vector<Point<Dim>>> sets;
  for (const auto& pose : driven.map.poses) {
    auto& set = sets.emplace_back();
    for (const auto& f : driven.map.features) {
      if ((f - pose).norm() < range) set.push_back(f);
    }
  }
  return NeighbourDensity<Dim>(sets);
}

/// The chance of a sighting for a sensor that sees all features within its range.
inline SightingChance chance_of(double range) {
  std::vector<SightingTrial> trials;
  for (int k = 0; k < 2000; ++k) trials.emplace_back(2.0 * range * k / 2000.0, k < 1000);
  return SightingChance(std::move(trials));
}

}  // namespace mapjoin::testing
