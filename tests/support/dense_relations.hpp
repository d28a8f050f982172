// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The covariances of relations against the inverse of the information in relative coordinates, dense.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <mapjoin/join/covariances/relations.hpp>
#include <tests/support/dense_information.hpp>

namespace mapjoin::testing {

/// ∂x_abs/∂x_rel. Rows and columns as in `layout`; those of a pose that hangs from the World are its own.
template <int Dim>
Eigen::MatrixXd J_absolute_relative(const Relations<Dim>& relations, const DenseInformation<Dim>& layout) {
  constexpr int kDof = kPoseDof<Dim>;
  const Values<Dim> state = composed(relations);
  const Eigen::Index size = layout.information().rows();
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(size, size);
  for (const Index pose : relations.order) {
    const auto& relation = relations.poses[static_cast<std::size_t>(pose)];
    const Eigen::Index row = layout.pose_row(pose);
    PoseMatrix<Dim> J_parent, J_child;
    compose(state.pose(relation.parent), relation.value, &J_parent, &J_child);
    if (relation.parent != kWorld) {
      T.middleRows<kDof>(row) = J_parent * T.middleRows<kDof>(layout.pose_row(relation.parent)).eval();
    }
    T.block<kDof, kDof>(row, row) = J_child;
  }
  for (std::size_t f = 0; f < relations.features.size(); ++f) {
    const auto& relation = relations.features[f];
    const Eigen::Index row = layout.feature_row(static_cast<Index>(f));
    PointPoseMatrix<Dim> J_parent;
    PointMatrix<Dim> J_child;
    transform(state.pose(relation.parent), relation.value, &J_parent, &J_child);
    if (relation.parent != kWorld) {
      T.middleRows<Dim>(row) = J_parent * T.middleRows<kDof>(layout.pose_row(relation.parent));
    }
    T.block<Dim, Dim>(row, row) = J_child;
  }
  return T;
}

template <int Dim>
void expect_relations_of(const DenseInformation<Dim>& information, const std::vector<Index>& held,
                         const Relations<Dim>& relations) {
  const Eigen::MatrixXd whole = information.inverse(held, J_absolute_relative(relations, information));
  const auto expect_block = [&](const auto& covariance, Eigen::Index row, const char* of, std::size_t index) {
    const Eigen::MatrixXd expected = whole.block(row, row, covariance.rows(), covariance.cols());
    EXPECT_LE((covariance - expected).norm(), 1e-9 * expected.norm()) << of << index;
  };
  for (std::size_t p = 0; p < relations.poses.size(); ++p) {
    expect_block(relations.poses[p].covariance, information.pose_row(static_cast<Index>(p)), "pose ", p);
  }
  for (std::size_t f = 0; f < relations.features.size(); ++f) {
    expect_block(relations.features[f].covariance, information.feature_row(static_cast<Index>(f)), "feature ", f);
  }
}

}  // namespace mapjoin::testing
