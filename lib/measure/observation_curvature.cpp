// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <mapjoin/measure/observation_curvature.hpp>

namespace mapjoin {

double ObservationTerm::value(double heading_error, const Point<2>& delta) const {
  const Point<2> u = Rotation<2>(heading_error).matrix() * measured;
  return (u - delta).squaredNorm() + heading_weight * heading_error * heading_error;
}

Matrix<3> ObservationTerm::hessian(double heading_error, const Point<2>& delta) const {
  const Point<2> u = Rotation<2>(heading_error).matrix() * measured;
  const Matrix<2, 1> u_prime = J_turned_rotation(u);
  Matrix<3> H;
  H << u.dot(delta) + heading_weight, -u_prime.transpose(), -u_prime, Matrix<2>::Identity();
  return 2.0 * H;
}

bool ObservationTerm::is_convex_at(double heading_error, const Point<2>& delta) const {
  const Point<2> u = Rotation<2>(heading_error).matrix() * measured;
  return u.dot(delta) + heading_weight >= measured.squaredNorm();
}

double ObservationTerm::border(double heading_error) const {
  return (measured.squaredNorm() - heading_weight) / (measured.norm() * std::cos(heading_error));
}

}  // namespace mapjoin
