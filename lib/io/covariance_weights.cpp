// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/covariance_weights.hpp>
#include <mapjoin/io/g2o_fields.hpp>
#include <mapjoin/io/information.hpp>

namespace mapjoin {

template <int Size>
Matrix<Size> inverse_of(const Matrix<Size>& covariance, TextScanner& text) {
  const auto W = information_of_covariance<Size>(covariance);
  if (!W) text.reject("the covariance that ends here is not positive definite");
  return W.value_or(Matrix<Size>::Zero());
}

template <int Size>
Fault covariance_of(const Matrix<Size>& information, Matrix<Size>& covariance) {
  const auto inverse = information_of_covariance<Size>(information);
  // Nor is it one that readers would not take.
  if (!inverse || !information_of_covariance<Size>(*inverse)) {
    return "has an information matrix that is singular, and so no covariance";
  }
  covariance = *inverse;
  return std::nullopt;
}

MeasuredPose<2> read_covariance_edge(TextScanner& text) {
  const Pose<2> measured = read_g2o_pose<2>(text);
  return {measured, inverse_of(text.symmetric<3>(), text)};
}

MeasuredPoint<2> read_covariance_point(TextScanner& text) {
  const Point<2> measured = text.vector<2>();
  return {measured, inverse_of(text.symmetric<2>(), text)};
}

Fault put_covariance_edge(const MeasuredPose<2>& edge, TextLine& line) {
  Matrix<3> P;
  if (auto fault = covariance_of(edge.information, P)) return fault;
  line.add(edge.measured).add_symmetric<3>(P);
  return std::nullopt;
}

Fault put_covariance_point(const MeasuredPoint<2>& point, TextLine& line) {
  Matrix<2> P;
  if (auto fault = covariance_of(point.information, P)) return fault;
  line.add<2>(point.measured).add_symmetric<2>(P);
  return std::nullopt;
}

template Fault covariance_of(const Matrix<2>&, Matrix<2>&);
template Fault covariance_of(const Matrix<3>&, Matrix<3>&);
template Fault covariance_of(const Matrix<Eigen::Dynamic>&, Matrix<Eigen::Dynamic>&);
template Matrix<2> inverse_of(const Matrix<2>&, TextScanner&);
template Matrix<3> inverse_of(const Matrix<3>&, TextScanner&);

}  // namespace mapjoin
