// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <mapjoin/join/own_given_shared.hpp>
#include <mapjoin/model/linearise.hpp>

namespace mapjoin {
namespace {

/// ∂H/∂(base, poses, features) of a map's targets.
template <int Dim>
Eigen::MatrixXd map_jacobian(const LocalMap<Dim>& map, const State<Dim>& state) {
  const Eigen::Index rows = map.information.rows();
  const Pose<Dim> base = state.pose(map.base);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, kPoseDof<Dim> + rows);
  Eigen::Index row = 0;
  const auto add = [&](const auto& linear) {
    const Eigen::Index dof = linear.residual.size();
    J.block(row, 0, dof, kPoseDof<Dim>) = linear.J_base;
    J.block(row, kPoseDof<Dim> + row, dof, dof) = linear.J_target;
    row += dof;
  };
  for (std::size_t p = 0; p < map.poses.size(); ++p) {
    add(linearise<Dim>(map.pose_estimates[p], base, state.pose(map.poses[p])));
  }
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    add(linearise<Dim>(map.feature_estimates[f], base, state.feature(map.features[f])));
  }
  return J;
}

}  // namespace

template <int Dim>
Eigen::Index OwnGivenShared<Dim>::row(Eigen::Index own) const {
  const auto count = static_cast<Eigen::Index>(poses.size());
  return std::min(own, count) * kPoseDof<Dim> + std::max<Eigen::Index>(0, own - count) * Dim;
}

template <int Dim>
Eigen::MatrixXd OwnGivenShared<Dim>::covariance(std::span<const Eigen::Index> own) const {
  std::vector<Eigen::Index> of_chain;
  Eigen::Index size = 0;
  for (const Eigen::Index k : own) {
    if (is_pose(k)) of_chain.push_back(k);
    size += dof(k);
  }
  Eigen::MatrixXd of_features = Eigen::MatrixXd::Zero(size, feature_covariance.rows());  // how e follows the features'
  Eigen::Index out = 0;
  for (const Eigen::Index k : own) {
    auto rows = of_features.middleRows(out, dof(k));
    if (is_pose(k)) {
      rows = pose_gain.middleRows(row(k), dof(k));
    } else {
      rows.middleCols(row(k) - row(static_cast<Eigen::Index>(poses.size())), Dim).setIdentity();
    }
    out += dof(k);
  }
  Eigen::MatrixXd Q = of_features * feature_covariance * of_features.transpose();
  const auto chain_size = static_cast<Eigen::Index>(of_chain.size()) * kPoseDof<Dim>;
  Q.topLeftCorner(chain_size, chain_size) += chain.covariance(of_chain);
  return Q;
}

template <int Dim>
OwnGivenShared<Dim> own_given_shared(const CondensedMap<Dim>& condensed, const State<Dim>& state) {
  OwnGivenShared<Dim> own;
  own.features = condensed.private_features;
  if (own.features.empty()) return own;
  // p = t_b + R_b p_local with p_local = p̂ + gain · (residuals of the others).
  const Pose<Dim> base = state.pose(condensed.map.base);
  const PointMatrix<Dim> R = base.rotation.matrix();
  own.gain = -condensed.gain * map_jacobian(condensed.map, state);
  const Eigen::Index size = own.gain.rows();
  own.feature_covariance = condensed.private_information.llt().solve(Eigen::MatrixXd::Identity(size, size));
  for (std::size_t f = 0; f < own.features.size(); ++f) {
    const auto rows = Eigen::seqN(static_cast<Eigen::Index>(f) * Dim, Dim);
    PointPoseMatrix<Dim> J_base;
    transform<Dim>(base, transform_into<Dim>(base, state.feature(own.features[f])), &J_base);
    own.gain(rows, Eigen::all) = (R * own.gain(rows, Eigen::all)).eval();
    own.gain(rows, Eigen::seqN(0, kPoseDof<Dim>)) += J_base;
    own.feature_covariance(rows, Eigen::all) = (R * own.feature_covariance(rows, Eigen::all)).eval();
    own.feature_covariance(Eigen::all, rows) = (own.feature_covariance(Eigen::all, rows) * R.transpose()).eval();
  }
  return own;
}

#define MAPJOIN_INSTANTIATE(Dim)       \
  template struct OwnGivenShared<Dim>; \
  template OwnGivenShared<Dim> own_given_shared(const CondensedMap<Dim>&, const State<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
