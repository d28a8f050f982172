// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The agreement of observations of a feature with each other, by the odometry between the poses that they were made from.

#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <vector>

namespace mapjoin {

/// Log-odds that each observation of a log is of the feature that it names; 0 if there is no other one to compare with. Two
/// observations of one feature, from poses not far apart along the drive, put it at two positions, whose difference v and its
/// covariance Σ make an Agreement of evidence ln(N(v; 0, Σ) V). V is the volume of the box around all observations of the log,
/// in the frames of their poses (m, at least 1 along every axis).
template <int Dim>
std::vector<double> sighting_odds(const OdometryChain<Dim>& chain, const Log<Dim>& log);

}  // namespace mapjoin
