// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Random poses, points and information matrices from a seeded engine, the same on every machine.

#include <mapjoin/geometry/pose.hpp>
#include <random>

namespace mapjoin::testing {

class Random {
 public:
  explicit Random(unsigned seed = 1) : engine_(seed) {}

  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() - std::mt19937::min()) /
                     static_cast<double>(std::mt19937::max() - std::mt19937::min());
  }
  template <int Rows>
  Vector<Rows> vector(double radius = 1.0) {
    Vector<Rows> v;
    for (int i = 0; i < Rows; ++i) v[i] = uniform(-radius, radius);
    return v;
  }
  template <int Dim>
  Pose<Dim> pose(double metres = 5.0, double radians = 1.5) {
    return {vector<Dim>(metres), Rotation<Dim>::exp(vector<kRotationDof<Dim>>(radians))};
  }
  /// A dense, well-conditioned, exactly symmetric positive definite matrix.
  template <int Rows>
  Matrix<Rows> information() {
    Matrix<Rows> A;
    for (int i = 0; i < Rows; ++i) A.col(i) = vector<Rows>();
    const Matrix<Rows> M = A * A.transpose() + Matrix<Rows>::Identity();
    return 0.5 * (M + M.transpose());
  }

 private:
  std::mt19937 engine_;
};

}  // namespace mapjoin::testing
