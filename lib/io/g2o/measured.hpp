// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The measurements in the edges, observations and priors of a g2o file, as the factors used inside take them.

#include <mapjoin/io/formats/edge_text.hpp>

namespace mapjoin {

/// Reads an edge, turned by from_g2o() before it is checked: weights that pass the check pass again once written and read back.
template <int Dim>
MeasuredPose<Dim> read_g2o_edge(TextScanner& text, const TextContext& context);

/// Reads an observation, in the frame of the pose; in space the offset of the sensor that the line names is applied.
template <int Dim>
MeasuredPoint<Dim> read_g2o_point(TextScanner& text, const TextContext& context);

/// Reads a prior as an edge from the World. A prior of a sensor becomes that of its robot, its weights turned at the
/// measurement, which is right to first order. Away from its pose a sensor must measure rotation too, otherwise the prior is
/// rejected: a position at the end of a lever says something of rotations that weights cannot express.
template <int Dim>
MeasuredPose<Dim> read_g2o_pose_prior(const PriorTag& tag, TextScanner& text, const TextContext& context);

}  // namespace mapjoin
