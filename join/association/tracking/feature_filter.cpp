// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <mapjoin/join/association/tracking/feature_filter.hpp>
#include <mapjoin/join/robust/support/odometry_chain.hpp>

namespace mapjoin {

template <int Dim>
void FeatureFilter<Dim>::move(const PoseFactor<Dim>& step) {
  constexpr int kDof = kPoseDof<Dim>;
  const bool is_forward = step.base < step.target;
  PoseMatrix<Dim> J_next_measured = PoseMatrix<Dim>::Identity();
  const Pose<Dim> next = is_forward ? step.measured : inverse(step.measured, &J_next_measured);
  const PoseMatrix<Dim> Q = J_next_measured * covariance_of(step.information) * J_next_measured.transpose();
  Eigen::MatrixXd J_features_next(covariance_.rows(), kDof);
  const PointMatrix<Dim> R_inverse = next.rotation.matrix().transpose();
  for (std::size_t k = 0; k < features_.size(); ++k) {
    PointPoseMatrix<Dim> J_next;
    features_[k] = transform_into<Dim>(next, features_[k], &J_next, nullptr);
    J_features_next.middleRows<Dim>(row(k)) = J_next;
    covariance_.middleRows<Dim>(row(k)) = (R_inverse * covariance_.middleRows<Dim>(row(k))).eval();
    covariance_.middleCols<Dim>(row(k)) = (covariance_.middleCols<Dim>(row(k)) * R_inverse.transpose()).eval();
  }
  covariance_.noalias() += J_features_next * Q * J_features_next.transpose();
}

template <int Dim>
void FeatureFilter<Dim>::add(const FeatureFactor<Dim>& observation) {
  const Eigen::Index before = covariance_.rows();
  covariance_.conservativeResize(before + Dim, before + Dim);
  covariance_.rightCols(Dim).setZero();
  covariance_.bottomRows(Dim).setZero();
  covariance_.template bottomRightCorner<Dim, Dim>() = covariance_of(observation.information);
  features_.push_back(observation.measured);
}

template <int Dim>
void FeatureFilter<Dim>::update(std::size_t feature, const FeatureFactor<Dim>& observation) {
  const Eigen::MatrixXd columns = covariance_.middleCols<Dim>(row(feature));
  const PointMatrix<Dim> S = PointMatrix<Dim>(columns.middleRows<Dim>(row(feature))) + covariance_of(observation.information);
  const Eigen::LLT<PointMatrix<Dim>> factor(S);
  const Eigen::MatrixXd gain = factor.solve(columns.transpose()).transpose();
  const Eigen::VectorXd step = gain * (observation.measured - features_[feature]);
  for (std::size_t k = 0; k < features_.size(); ++k) features_[k] += step.segment<Dim>(row(k));
  covariance_.noalias() -= gain * columns.transpose();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

template class FeatureFilter<2>;
template class FeatureFilter<3>;

}  // namespace mapjoin
