// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Random logs with their local maps, and exact comparison of what a store gives back.

#include <gtest/gtest.h>

#include <mapjoin/io/store/store.hpp>
#include <tests/support/random.hpp>

namespace mapjoin::testing {

template <int Dim>
PoseFactor<Dim> random_pose_observation(Random& random, PoseIndex base, PoseIndex target) {
  return {base, target, random.pose<Dim>(), random.information<kPoseDof<Dim>>()};
}

template <int Dim>
FeatureFactor<Dim> random_feature_observation(Random& random, PoseIndex base, FeatureIndex target) {
  return {base, target, random.vector<Dim>(), random.information<Dim>()};
}

template <int Dim>
LocalMap<Dim> random_map(Random& random, const Segment& segment, int features) {
  LocalMap<Dim> map;
  map.base = segment.begin;
  map.poses = {segment.end};
  map.pose_estimates = {random.pose<Dim>()};
  for (int i = 0; i < features; ++i) {
    map.features.emplace_back(features - 1 - i);
    map.feature_estimates.push_back(random.vector<Dim>(9.0));
  }
  const Eigen::Index n = kPoseDof<Dim> + Dim * features;
  Eigen::MatrixXd A(n, n);
  for (double& entry : A.reshaped()) entry = random.uniform(-1.0, 1.0);
  map.information = A * A.transpose();
  map.information.template triangularView<Eigen::StrictlyLower>() = map.information.transpose();
  map.chi2 = random.uniform(0.0, 10.0);
  return map;
}

/// Random maps over `maps` segments of two steps each, with a raw segment of one step behind them. None of the arrays that a
/// store has for the log is empty.
template <int Dim>
StoredMaps<Dim> random_stored_maps(Random& random, int maps, int features = 5) {
  StoredMaps<Dim> stored;
  Log<Dim>& log = stored.log;
  const int poses = 2 * maps + 2;
  log.source = "some folder/some log.g2o";
  for (int i = 0; i < poses; ++i) {
    log.poses.push_back({7, std::uint64_t{0x6100000000000000} + static_cast<std::uint64_t>(i)});
    log.stamps_ns.push_back(-5 + 1'000'000'000'000'000'007 * (i % 9));
    log.initial.poses.push_back(random.pose<Dim>());
    if (i > 0) log.graph.pose_factors.push_back(random_pose_observation<Dim>(random, PoseIndex(i - 1), PoseIndex(i)));
    log.graph.feature_factors.push_back(random_feature_observation<Dim>(random, PoseIndex(i), FeatureIndex(i % features)));
  }
  for (int i = 0; i < features; ++i) {
    log.features.push_back({~std::uint64_t{0} - static_cast<std::uint64_t>(features - i)});
    log.initial.features.push_back(random.vector<Dim>());
  }
  log.sessions = {{0, PoseIndex(poses)}};
  log.graph.pose_factors.push_back(random_pose_observation<Dim>(random, PoseIndex(poses - 1), 0));
  log.graph.pose_factors.push_back(random_pose_observation<Dim>(random, kWorld, 1));
  log.graph.feature_factors.push_back(random_feature_observation<Dim>(random, kWorld, 2));
  log.graph.fixed = {{0, random.pose<Dim>()}};
  log.unassociated = 4;
  log.conventions = {PoseError::kG2o, RotationInformation::kQuaternion, Covariance::kIdentity, {3, 1.25e-7, 5}};
  for (PoseIndex begin = 0; begin.value < 2 * maps; begin += 2) {
    stored.segments.push_back({begin, begin + 2, true});
    stored.maps.push_back(random_map<Dim>(random, stored.segments.back(), features));
  }
  stored.segments.push_back({PoseIndex(poses - 2), PoseIndex(poses - 1), false});
  stored.options = "--poses-per-map 2";
  return stored;
}

inline bool same(const Rotation<2>& a, const Rotation<2>& b) {
  return a.angle() == b.angle();
}
inline bool same(const Rotation<3>& a, const Rotation<3>& b) {
  return a.quaternion().coeffs() == b.quaternion().coeffs();
}
template <int Rows>
bool same(const Vector<Rows>& a, const Vector<Rows>& b) {
  return a == b;
}
template <int Dim>
bool same(const Pose<Dim>& a, const Pose<Dim>& b) {
  return a.translation == b.translation && same(a.rotation, b.rotation);
}
template <int Dim>
bool same(const FixedPose<Dim>& a, const FixedPose<Dim>& b) {
  return a.pose == b.pose && same(a.value, b.value);
}
inline bool same(const Session& a, const Session& b) {
  return a.begin == b.begin && a.end == b.end;
}
template <typename Observation>
requires requires(Observation o) {
  o.loss;
}
bool same(const Observation& a, const Observation& b) {
  return a.base == b.base && a.target == b.target && same(a.measured, b.measured) && a.information == b.information &&
         a.loss == b.loss;
}
template <int Dim>
bool same(const LocalMap<Dim>& a, const LocalMap<Dim>& b);
template <typename T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const T& x, const T& y) { return same(x, y); });
}
template <int Dim>
bool same(const LocalMap<Dim>& a, const LocalMap<Dim>& b) {
  return a.base == b.base && a.poses == b.poses && a.features == b.features && same(a.pose_estimates, b.pose_estimates) &&
         a.feature_estimates == b.feature_estimates && a.information == b.information && a.chi2 == b.chi2;
}

template <int Dim>
void expect_same(const StoredMaps<Dim>& a, const StoredMaps<Dim>& b) {
  EXPECT_EQ(a.log.source, b.log.source);
  EXPECT_EQ(a.log.poses, b.log.poses);
  EXPECT_EQ(a.log.features, b.log.features);
  EXPECT_TRUE(same(a.log.sessions, b.log.sessions));
  EXPECT_TRUE(same(a.log.graph.pose_factors, b.log.graph.pose_factors));
  EXPECT_TRUE(same(a.log.graph.feature_factors, b.log.graph.feature_factors));
  EXPECT_TRUE(same(a.log.graph.fixed, b.log.graph.fixed));
  EXPECT_EQ(a.log.stamps_ns, b.log.stamps_ns);
  EXPECT_TRUE(same(a.log.initial.poses, b.log.initial.poses));
  EXPECT_TRUE(same(a.log.initial.features, b.log.initial.features));
  EXPECT_EQ(a.log.repeated_edges, b.log.repeated_edges);
  EXPECT_EQ(a.log.unassociated, b.log.unassociated);
  EXPECT_EQ(a.log.conventions.pose_error, b.log.conventions.pose_error);
  EXPECT_EQ(a.log.conventions.rotation_information, b.log.conventions.rotation_information);
  EXPECT_EQ(a.log.conventions.covariance, b.log.conventions.covariance);
  EXPECT_EQ(a.log.conventions.repairs.indefinite, b.log.conventions.repairs.indefinite);
  EXPECT_EQ(a.log.conventions.repairs.symmetrised, b.log.conventions.repairs.symmetrised);
  EXPECT_EQ(a.log.conventions.repairs.largest_asymmetry, b.log.conventions.repairs.largest_asymmetry);
  EXPECT_EQ(a.segments, b.segments);
  EXPECT_TRUE(same(a.maps, b.maps));
  EXPECT_EQ(a.options, b.options);
  EXPECT_EQ(a.share, b.share);
}

}  // namespace mapjoin::testing
