// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the edges, observations and priors of a g2o file measure, as the factors used inside take it.

#include <mapjoin/io/formats/edge_text.hpp>

namespace mapjoin {

/// Turned by from_g2o() before it is checked: what passes the check then passes again where it is written and read back.
template <int Dim>
MeasuredPose<Dim> read_g2o_edge(TextScanner& text, const TextContext& context);

/// In the frame of the pose, wherever the sensor stands that, in space, the line names.
template <int Dim>
MeasuredPoint<Dim> read_g2o_point(TextScanner& text, const TextContext& context);

/// A prior as an edge from the World. One of a sensor becomes that of its robot, its weights turned at the measurement, which
/// is right to the first order; it is rejected where its rotation was not measured, for a position at the end of a lever would
/// say something of rotations that weights cannot.
template <int Dim>
MeasuredPose<Dim> read_g2o_pose_prior(const PriorTag& tag, TextScanner& text, const TextContext& context);

}  // namespace mapjoin
