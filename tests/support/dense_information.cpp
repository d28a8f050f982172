// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <mapjoin/model/accumulate.hpp>
#include <tests/support/dense_information.hpp>

namespace mapjoin::testing {
namespace {

struct Sink {
  Eigen::MatrixXd& H;
  std::vector<Eigen::Index> rows;

  template <typename Block>
  void hessian(int i, int j, const Block& block) {
    const Eigen::Index a = rows[static_cast<std::size_t>(i)];
    const Eigen::Index b = rows[static_cast<std::size_t>(j)];
    if (a < 0 || b < 0) return;
    H.block(a, b, block.rows(), block.cols()) += block;
    if (i != j) H.block(b, a, block.cols(), block.rows()) += block.transpose();
  }
  template <typename Block>
  void rhs(int, const Block&) {}
};

}  // namespace

template <int Dim>
DenseInformation<Dim>::DenseInformation(const Values<Dim>& state) : state_(state) {
  const Eigen::Index size = feature_row(indices(state.features).last);
  H_ = Eigen::MatrixXd::Zero(size, size);
}

template <int Dim>
void DenseInformation<Dim>::add(const PoseFactor<Dim>& o) {
  accumulate(linearise(o, state_.pose(o.base), state_.pose(o.target)), Sink{H_, {pose_row(o.base), pose_row(o.target)}});
}

template <int Dim>
void DenseInformation<Dim>::add(const FeatureFactor<Dim>& o) {
  accumulate(linearise(o, state_.pose(o.base), state_.features[o.target]), Sink{H_, {pose_row(o.base), feature_row(o.target)}});
}

template <int Dim>
void DenseInformation<Dim>::add(const LocalMap<Dim>& map) {
  LinearMap<Dim> linear;
  linear.map = &map;
  std::vector<Eigen::Index> rows{pose_row(map.base)};
  for (std::size_t p = 0; p < map.poses.size(); ++p) {
    linear.poses.push_back(linearise<Dim>(map.pose_estimates[p], state_.pose(map.base), state_.pose(map.poses[p])));
    rows.push_back(pose_row(map.poses[p]));
  }
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    linear.features.push_back(
        linearise<Dim>(map.feature_estimates[f], state_.pose(map.base), state_.features[map.features[f]]));
    rows.push_back(feature_row(map.features[f]));
  }
  accumulate(linear, Sink{H_, rows});
}

template <int Dim>
void DenseInformation<Dim>::add(const std::vector<Eigen::Index>& rows, const Eigen::MatrixXd& information) {
  H_(rows, rows) += information;
}

template <int Dim>
Eigen::MatrixXd DenseInformation<Dim>::inverse(const std::vector<PoseIndex>& held) const {
  const auto free = free_rows(held);
  return inverse(free, Eigen::MatrixXd(H_(free, free)).template cast<long double>());
}

template <int Dim>
Eigen::MatrixXd DenseInformation<Dim>::inverse(const std::vector<PoseIndex>& held, const Eigen::MatrixXd& T) const {
  const auto free = free_rows(held);
  const Extended T_free = Eigen::MatrixXd(T(free, free)).template cast<long double>();
  const Extended H_T = Eigen::MatrixXd(H_(free, free)).template cast<long double>() * T_free;
  return inverse(free, T_free.transpose() * H_T);
}

template <int Dim>
std::vector<Eigen::Index> DenseInformation<Dim>::free_rows(const std::vector<PoseIndex>& held) const {
  std::vector<Eigen::Index> free;
  for (Eigen::Index row = 0; row < H_.rows(); ++row) {
    const bool is_anchored =
        row < feature_row(0) && std::find(held.begin(), held.end(), PoseIndex(row / kPoseDof<Dim>)) != held.end();
    if (!is_anchored) free.push_back(row);
  }
  return free;
}

template <int Dim>
Eigen::MatrixXd DenseInformation<Dim>::inverse(const std::vector<Eigen::Index>& free, const Extended& H) const {
  const Extended unit = Extended::Identity(H.rows(), H.cols());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(H_.rows(), H_.cols());
  covariance(free, free) = H.llt().solve(unit).template cast<double>();
  return covariance;
}

template class DenseInformation<2>;
template class DenseInformation<3>;

}  // namespace mapjoin::testing
