// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/formats/covariance_weights.hpp>
#include <mapjoin/io/g2o/fields.hpp>

namespace mapjoin {

template <int Size>
Matrix<Size> inverse_of(Matrix<Size> covariance, InformationCheck& check, TextScanner& text) {
  if (const auto fault = check.invert<Size>(covariance)) text.reject("the covariance that ends here " + *fault);
  return covariance;
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

MeasuredPose<2> read_covariance_edge(TextScanner& text, InformationCheck& check) {
  const Pose<2> measured = read_g2o_pose<2>(text);
  return {measured, inverse_of<3>(text.symmetric<3>(), check, text)};
}

MeasuredPoint<2> read_covariance_point(TextScanner& text, InformationCheck& check) {
  const Point<2> measured = text.vector<2>();
  return {measured, inverse_of<2>(text.symmetric<2>(), check, text)};
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
template Matrix<2> inverse_of(Matrix<2>, InformationCheck&, TextScanner&);
template Matrix<3> inverse_of(Matrix<3>, InformationCheck&, TextScanner&);

}  // namespace mapjoin
