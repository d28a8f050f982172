// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A check of the covariances of relations against the dense inverse of the information matrix in relative coordinates.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <mapjoin/join/covariances/relations.hpp>
#include <tests/support/dense_information.hpp>

namespace mapjoin::testing {

/// The Jacobian ∂x_abs/∂x_rel, rows and columns as in `layout`. A pose or feature whose parent is the World depends on its own
/// relation alone.
template <int Dim>
Eigen::MatrixXd J_absolute_relative(const Relations<Dim>& relations, const DenseInformation<Dim>& layout) {
  constexpr int kDof = kPoseDof<Dim>;
  const Values<Dim> state = composed(relations);
  const Eigen::Index size = layout.information().rows();
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(size, size);
  for (const PoseIndex pose : relations.order) {
    const auto& relation = relations.poses[pose];
    const Eigen::Index row = layout.pose_row(pose);
    PoseMatrix<Dim> J_parent, J_child;
    compose(state.pose(relation.parent), relation.value, &J_parent, &J_child);
    if (relation.parent != kWorld) {
      T.middleRows<kDof>(row) = J_parent * T.middleRows<kDof>(layout.pose_row(relation.parent)).eval();
    }
    T.block<kDof, kDof>(row, row) = J_child;
  }
  for (const FeatureIndex f : indices(relations.features)) {
    const auto& relation = relations.features[f];
    const Eigen::Index row = layout.feature_row(f);
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
void expect_relations_of(const DenseInformation<Dim>& information, const std::vector<PoseIndex>& held,
                         const Relations<Dim>& relations) {
  const Eigen::MatrixXd whole = information.inverse(held, J_absolute_relative(relations, information));
  const auto expect_block = [&](const auto& covariance, Eigen::Index row, const char* of, int index) {
    const Eigen::MatrixXd expected = whole.block(row, row, covariance.rows(), covariance.cols());
    EXPECT_LE((covariance - expected).norm(), 1e-9 * expected.norm()) << of << index;
  };
  for (const PoseIndex p : indices(relations.poses)) {
    expect_block(relations.poses[p].covariance, information.pose_row(p), "pose ", p.value);
  }
  for (const FeatureIndex f : indices(relations.features)) {
    expect_block(relations.features[f].covariance, information.feature_row(f), "feature ", f.value);
  }
}

}  // namespace mapjoin::testing
