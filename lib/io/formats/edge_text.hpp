// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the text formats of edges have in common: lines of a tag, two ids, a measurement and its weights, read and written by
// one driver. Each format says how it writes these down.

#include <filesystem>
#include <mapjoin/io/files/text_line.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace mapjoin {

template <int Dim>
struct MeasuredPose {
  Pose<Dim> measured;
  PoseMatrix<Dim> information;
};

template <int Dim>
struct MeasuredPoint {
  Point<Dim> measured;
  PointMatrix<Dim> information;
};

/// A fault, to follow the name of an edge; nothing where there is none.
using Fault = std::optional<std::string>;

/// One format in one dimension. What goes wrong with words is rejected on the scanner, what the format has no words for is a
/// fault. The check is for what is no information matrix yet: of these the driver takes care.
template <int Dim>
struct EdgeText {
  std::string_view name{};             ///< "TORO's files".
  std::string_view comment{};          ///< The first line of what is written, without `#`.
  std::string_view edge_tag{};         ///< `tag i j …`: pose j from pose i.
  std::string_view observation_tag{};  ///< `tag i f …`: feature f from pose i. Empty: there are none.
  std::string_view pose_tag{};         ///< `tag i …`: the value of a pose. Empty: there are none.
  bool one_numbering = false;          ///< Of poses and features, where it is written.

  MeasuredPose<Dim> (*read_edge)(TextScanner& text, InformationCheck& check) = nullptr;
  MeasuredPoint<Dim> (*read_point)(TextScanner& text, InformationCheck& check) = nullptr;
  Pose<Dim> (*read_pose)(TextScanner& text) = nullptr;

  Fault (*put_edge)(const MeasuredPose<Dim>& edge, TextLine& line) = nullptr;
  Fault (*put_point)(const MeasuredPoint<Dim>& point, TextLine& line) = nullptr;
  Fault (*put_pose)(const Pose<Dim>& pose, TextLine& line) = nullptr;
};

/// The log in `text`, which stands at the begin of a file. Poses and features are named apart. Bad input, with its place: an
/// unknown tag, an edge from a pose to itself, information that InformationCheck refuses, a pose with two values; and an edge
/// to a pose without a value in a file that gives any.
template <int Dim>
Expected<AnyLog> read_edge_text(TextScanner text, const EdgeText<Dim>& format, const ReadOptions& options);

/// Writes edges and observations, and the values of poses where the format has them, which then must be there; nothing else of
/// the log. Further sessions are numbered from a power of ten. kUsage where the format has no words for something;
/// kCannotWrite.
template <int Dim>
Expected<void> write_edge_text(const Log<Dim>& log, const EdgeText<Dim>& format, const std::filesystem::path& path);

}  // namespace mapjoin
