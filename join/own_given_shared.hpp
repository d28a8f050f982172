// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a local map keeps to itself, interior poses and private features, as a Gaussian given what it shares with the joined
// state:
//
//   δ_own = A δ_shared + e,    e of the features ~ N(0, Q_f),    e of the poses = B (e of the features) + e of the chain.
//
// The e of different maps are independent, so that any covariance is that of the joined state, carried by A, and Q.

#include <Eigen/Core>
#include <mapjoin/localmap/condense.hpp>
#include <mapjoin/model/state.hpp>
#include <mapjoin/solve/chain_given_border.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// Own variables are counted poses first, then features; their rows are laid out alike (kPoseDof, Dim each).
template <int Dim>
struct OwnGivenShared {
  std::vector<Index> poses;            ///< Interior, of the log.
  std::vector<Index> features;         ///< Private.
  Eigen::MatrixXd gain;                ///< A; columns are the map's base, kept poses and shared features, held ones, too.
  Eigen::MatrixXd feature_covariance;  ///< Q_f
  Eigen::MatrixXd pose_gain;           ///< B
  ChainGivenBorder<Dim> chain;

  Eigen::Index size() const { return static_cast<Eigen::Index>(poses.size() + features.size()); }
  bool is_pose(Eigen::Index own) const { return own < static_cast<Eigen::Index>(poses.size()); }
  int dof(Eigen::Index own) const { return is_pose(own) ? kPoseDof<Dim> : Dim; }
  /// Where the rows of an own variable begin.
  Eigen::Index row(Eigen::Index own) const;
  /// Q: the joint covariance of own variables, ascending, where what is shared stands still.
  Eigen::MatrixXd covariance(std::span<const Eigen::Index> own) const;
};

/// Of the private features of a map whose targets stand as in `state`.
template <int Dim>
OwnGivenShared<Dim> own_given_shared(const CondensedMap<Dim>& condensed, const State<Dim>& state);

}  // namespace mapjoin
