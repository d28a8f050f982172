// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Do observations of a feature agree with each other? By the odometry between the poses that they were made from.

#include <mapjoin/join/robust/odometry_chain.hpp>
#include <vector>

namespace mapjoin {

/// Logarithms of the odds that each observation of a log is of the feature that it names: it and another observation of the
/// same feature, from a pose not far along the drive, put the feature at two positions, whose difference v and its covariance Σ
/// make an Agreement of evidence ln(N(v; 0, Σ) V); V is the volume of the box that all observations of the log lie in, in the
/// frames of their poses (m, at least 1 along every axis). 0 where there is no other observation to compare with.
template <int Dim>
std::vector<double> sighting_odds(const OdometryChain<Dim>& chain, const Log<Dim>& log);

}  // namespace mapjoin
