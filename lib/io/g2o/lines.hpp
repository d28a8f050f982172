// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The lines of a piece of a g2o file, each by itself: what they mean together is the reader's.

#include <cstdint>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <variant>
#include <vector>

namespace mapjoin {

template <int Dim>
struct G2oPoseVertex {
  Place place;
  PoseId id;
  Pose<Dim> pose;
};

template <int Dim>
struct G2oFeatureVertex {
  Place place;
  FeatureId id;
  Point<Dim> point;
};

struct G2oFix {
  std::vector<PoseId> ids;
};

/// Its information weighs the paper's residual, and is checked.
template <int Dim>
struct G2oPoseEdge {
  PoseId base;
  PoseId target;
  Pose<Dim> measured;
  PoseMatrix<Dim> information;
};

/// In the frame of the pose, wherever the sensor stands; its information is checked.
template <int Dim>
struct G2oObservation {
  PoseId pose;
  FeatureId feature;
  Point<Dim> measured;
  PointMatrix<Dim> information;
};

template <int Dim>
using G2oLine = std::variant<G2oPoseVertex<Dim>, G2oFeatureVertex<Dim>, G2oFix, G2oPoseEdge<Dim>, G2oObservation<Dim>>;

template <int Dim>
struct G2oLines {
  std::vector<G2oLine<Dim>> lines;
  MatrixRepairs repairs;
  std::optional<Error> fault;  ///< What is wrong with the line after these.
};

/// Reads `piece` as far as it is right. `offsets` are those of the whole file, or what is wrong with them.
template <int Dim>
G2oLines<Dim> read_g2o_lines(TextScanner piece, const ReadOptions& options, const Expected<G2oOffsets>& offsets);

}  // namespace mapjoin
