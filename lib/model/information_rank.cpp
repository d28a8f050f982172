// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <mapjoin/model/information_rank.hpp>

namespace mapjoin {

template <int Rows>
std::int64_t information_rank(const Eigen::Matrix<double, Rows, Rows>& W) {
  constexpr double kZero = 1e-9;
  const Eigen::Matrix<double, Rows, 1> diagonal = W.diagonal();
  const Eigen::Matrix<double, Rows, 1> scale = (diagonal.array() > 0.0).select(diagonal.array().rsqrt(), 0.0);
  const Eigen::LDLT<Eigen::Matrix<double, Rows, Rows>> ldlt(scale.asDiagonal() * W * scale.asDiagonal());
  return (ldlt.vectorD().array() > kZero).count();
}

template std::int64_t information_rank(const Eigen::Matrix<double, 2, 2>&);
template std::int64_t information_rank(const Eigen::Matrix<double, 3, 3>&);
template std::int64_t information_rank(const Eigen::Matrix<double, 6, 6>&);
template std::int64_t information_rank(const Eigen::MatrixXd&);

}  // namespace mapjoin
