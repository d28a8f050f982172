// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Comparison of two logs, number by number.

#include <gtest/gtest.h>

#include <mapjoin/model/log.hpp>

namespace mapjoin::testing {

/// Allowed differences; 0: the same bits.
struct SameLogTolerance {
  double measured = 0.0;
  double information = 0.0;  ///< Allowed difference relative to the largest entry.
};

template <typename Matrices>
void expect_same_matrix(const Matrices& a, const Matrices& b, double tolerance) {
  if (tolerance == 0.0) {
    EXPECT_EQ(a, b);
  } else {
    EXPECT_LE((a - b).cwiseAbs().maxCoeff(), tolerance) << a << "\n\n" << b;
  }
}

inline void expect_same_rotation(const Rotation<2>& a, const Rotation<2>& b, double tolerance) {
  if (tolerance == 0.0) {
    EXPECT_EQ(a.angle(), b.angle());
  } else {
    EXPECT_LE(std::abs((a.inverse() * b).log()[0]), tolerance);
  }
}
inline void expect_same_rotation(const Rotation<3>& a, const Rotation<3>& b, double tolerance) {
  if (tolerance == 0.0) {
    EXPECT_EQ(a.quaternion().coeffs(), b.quaternion().coeffs());
  } else {
    EXPECT_LE((a.inverse() * b).log().norm(), tolerance);
  }
}

template <int Dim>
void expect_same_value(const Pose<Dim>& a, const Pose<Dim>& b, double tolerance) {
  expect_same_matrix(a.translation, b.translation, tolerance);
  expect_same_rotation(a.rotation, b.rotation, tolerance);
}
template <int Size>
void expect_same_value(const Eigen::Matrix<double, Size, 1>& a, const Eigen::Matrix<double, Size, 1>& b, double tolerance) {
  expect_same_matrix(a, b, tolerance);
}

template <typename Observation>
void expect_same_observations(std::span<const Observation> a, std::span<const Observation> b,
                              const SameLogTolerance& tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].base, b[i].base);
    EXPECT_EQ(a[i].target, b[i].target);
    expect_same_value(a[i].measured, b[i].measured, tolerance.measured);
    expect_same_matrix(a[i].information, b[i].information, tolerance.information * a[i].information.cwiseAbs().maxCoeff());
  }
}

/// Expects equal names, edges and observations; priors, fixed poses and initial values are not compared.
template <int Dim>
void expect_same_log(const Log<Dim>& a, const Log<Dim>& b, const SameLogTolerance& tolerance = {}) {
  EXPECT_EQ(a.poses, b.poses);
  EXPECT_EQ(a.features, b.features);
  expect_same_observations(a.odometry(), b.odometry(), tolerance);
  expect_same_observations(a.closures(), b.closures(), tolerance);
  expect_same_observations(a.observations(), b.observations(), tolerance);
}

}  // namespace mapjoin::testing
