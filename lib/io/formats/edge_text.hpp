// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The common part of the text formats of edges: lines of a tag, two ids, a measurement and its weights, read and written by one
// driver. A format is a table of its tags, and of functions if its numbers are its own.

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <mapjoin/io/files/text_line.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <span>
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

/// A fault, worded to follow the name of an edge; nullopt if none.
using Fault = std::optional<std::string>;

/// An edge or an observation by its ends, as messages name it.
inline std::string name_of(const PoseId& base, const PoseId& target) {
  return "the edge from " + to_string(base) + " to " + to_string(target);
}
inline std::string name_of(const PoseId& base, const FeatureId& target) {
  return "the observation of " + to_string(target) + " from " + to_string(base);
}

/// The context that the lines of a file are read in.
struct TextContext {
  const ReadOptions& options;
  bool is_whole;       ///< False for some lines of a file: others may declare what they name, and `FIX` is passed over.
  G2oOffsets offsets;  ///< Poses of sensors, by their ids.
  mutable std::atomic<std::int64_t> unweighed = 0;  ///< Lines without weights that got the identity.
};

/// True if the line ends where its weights are expected and the identity is taken for them; the line is rejected if that is not
/// allowed.
bool is_unweighed(TextScanner& text, const TextContext& context);

/// Reads the upper triangle of the weights of a line, row by row; the identity if they are missing and may be.
template <int Size>
Matrix<Size> read_weights(TextScanner& text, const TextContext& context) {
  return is_unweighed(text, context) ? Matrix<Size>(Matrix<Size>::Identity()) : text.symmetric<Size>();
}

/// The numbers of an edge as they are: the measurement, then the upper triangle of its weights, row by row.
template <int Dim>
MeasuredPose<Dim> read_plain_edge(TextScanner& text, const TextContext& context) {
  const Pose<Dim> measured = read_g2o_pose<Dim>(text);
  return {measured, read_weights<kPoseDof<Dim>>(text, context)};
}
template <int Dim>
MeasuredPoint<Dim> read_plain_point(TextScanner& text, const TextContext& context) {
  const Point<Dim> measured = text.vector<Dim>();
  return {measured, read_weights<Dim>(text, context)};
}
template <int Dim>
Fault put_plain_edge(const MeasuredPose<Dim>& edge, TextLine& line) {
  line.add(edge.measured).template add_symmetric<kPoseDof<Dim>>(edge.information);
  return std::nullopt;
}
template <int Dim>
Fault put_plain_point(const MeasuredPoint<Dim>& point, TextLine& line) {
  line.template add<Dim>(point.measured).template add_symmetric<Dim>(point.information);
  return std::nullopt;
}
template <int Dim>
Fault put_plain_pose(const Pose<Dim>& pose, TextLine& line) {
  line.add(pose);
  return std::nullopt;
}

/// The form in which a format gives information matrices over the steps.
enum class Weights : std::uint8_t {
  kExact,       ///< Information matrices as they are.
  kAngles,      ///< Information matrices, in space over the angles.
  kSquareRoot,  ///< Square roots of information matrices, in space over the angles.
  kCovariance,  ///< Covariances.
};

/// The tag of a kind of priors, measured from the World: `tag i …`, or with a sensor `tag i offset …`.
struct PriorTag {
  enum class Kind : std::uint8_t {
    kPose,
    kPosition,  ///< Position of a pose.
    kPlanar,    ///< x and y of a pose in space.
    kFeature,
  };
  enum class Sensor : std::uint8_t {
    kNone,
    kNamed,    ///< The pose of the named sensor is measured.
    kIgnored,  ///< The sensor is ignored, as g2o's own program does.
  };
  std::string_view tag;
  Kind kind;
  Sensor sensor = Sensor::kNone;
};

/// One format in one dimension. Malformed words are rejected on the scanner; a value that the format cannot express is a fault.
/// The driver checks information matrices, and inverts covariances. An empty tag stands for lines that the format does not
/// have.
template <int Dim>
struct EdgeText {
  std::string_view name{};             ///< In messages: "TORO's files".
  std::string_view comment{};          ///< The first line of a written file, without `#`.
  std::string_view edge_tag{};         ///< `tag i j …`: pose j from pose i.
  std::string_view offset_line{};      ///< Written before the first observation or prior of a pose.
  std::string_view observation_tag{};  ///< `tag i f …`: feature f from pose i.
  std::string_view pose_tag{};         ///< `tag i …`: the value of a pose.
  std::string_view feature_tag{};      ///< `tag f …`: the value of a feature.
  bool one_numbering = false;          ///< True if poses and features share one numbering in written files.
  Weights weights = Weights::kExact;
  bool may_be_unassociated = false;  ///< True if an observation of feature -1 is left out, and counted.
  bool has_g2o_lines = false;        ///< True if lines may be `FIX`, or `PARAMS_…` that say nothing by themselves.
  std::span<const PriorTag> priors{};
  /// True for the tags of lines with no place in a log, which are left out and counted; null if there are no such tags.
  bool (*is_passed_over)(std::string_view tag) = nullptr;
  /// True for the tags of this format in the other dimension, for the message; null if unknown.
  bool (*is_of_other_dimension)(std::string_view tag) = nullptr;

  MeasuredPose<Dim> (*read_edge)(TextScanner& text, const TextContext& context) = read_plain_edge<Dim>;
  MeasuredPoint<Dim> (*read_point)(TextScanner& text, const TextContext& context) = read_plain_point<Dim>;
  /// Reads a prior of a pose; coordinates that were not measured have no weight. Null if the format has no priors.
  MeasuredPose<Dim> (*read_pose_prior)(const PriorTag& tag, TextScanner& text, const TextContext& context) = nullptr;
  Pose<Dim> (*read_pose)(TextScanner& text) = read_g2o_pose<Dim>;

  Fault (*put_edge)(const MeasuredPose<Dim>& edge, TextLine& line) = put_plain_edge<Dim>;
  Fault (*put_point)(const MeasuredPoint<Dim>& point, TextLine& line) = put_plain_point<Dim>;
  Fault (*put_pose)(const Pose<Dim>& pose, TextLine& line) = put_plain_pose<Dim>;

  constexpr const PriorTag* prior(std::string_view tag) const {
    const auto found = std::ranges::find(priors, tag, &PriorTag::tag);
    return found == priors.end() ? nullptr : &*found;
  }
  constexpr bool has_tag(std::string_view tag) const {
    return tag == edge_tag || tag == observation_tag || tag == pose_tag || tag == feature_tag || prior(tag) != nullptr;
  }
};

/// Reads the next word as the id of a feature; nullopt if it is -1.
std::optional<FeatureId> read_feature_or_none(TextScanner& text);

/// The information matrix of the covariance that the line gives up to here; a covariance that the check refuses is rejected.
template <int Size>
Matrix<Size> inverse_of(Matrix<Size> covariance, InformationCheck& check, TextScanner& text);

/// The covariance of an information matrix; a fault if this is singular.
template <int Size>
Fault covariance_of(const Matrix<Size>& information, Matrix<Size>& covariance);

/// The extent of a text, and of the pieces that it is read in.
struct Extent {
  bool is_whole = true;                            ///< True for a whole file; see TextContext.
  bool needs_poses = true;                         ///< False: lines of features alone are a log, too.
  std::size_t piece_bytes = std::size_t{1} << 16;  ///< Size of pieces that are read in parallel; the log does not depend on it.
};

/// The log in `text`, which stands at the start of a file, in the dimension of the first tag. Poses and features are named
/// apart. Bad input, with its place, unless the options say otherwise: an unknown tag, an edge from a pose to itself or without
/// weights, an information matrix that InformationCheck refuses; a pose or feature with two values; and, in a file that gives
/// values, an edge to a pose or feature without one.
Expected<AnyLog> read_edge_text(TextScanner text, const EdgeText<2>& plane, const EdgeText<3>* space,
                                const ReadOptions& options, Extent extent = {});

/// The contents of a written file, in this order. A null pointer, or a tag that the format does not have, leaves its lines out.
template <int Dim>
struct EdgeTextContents {
  std::string_view source;  ///< For messages.
  const PoseIds& pose_ids;
  const FeatureIds& feature_ids;
  std::vector<std::string> comments;  ///< Lines, without `#`.
  const Table<PoseIndex, Pose<Dim>>* poses = nullptr;
  const Table<FeatureIndex, Point<Dim>>* features = nullptr;
  std::vector<PoseIndex> fixed{};
  const Log<Dim>* log = nullptr;  ///< Edges, observations and priors, over these poses and features.
};

/// Writes the contents in a format; further sessions are numbered from a power of ten. kUsage if the format cannot express
/// something, or the keys do not fit into one numbering; kCannotWrite.
template <int Dim>
Expected<void> write_edge_text(const EdgeTextContents<Dim>& contents, const EdgeText<Dim>& format,
                               const std::filesystem::path& path);

/// Writes a log's edges and observations and, if the format has them, the values of its poses; nothing else. Errors as for
/// EdgeTextContents; kUsage also if these values are missing.
template <int Dim>
Expected<void> write_edge_text(const Log<Dim>& log, const EdgeText<Dim>& format, const std::filesystem::path& path);

}  // namespace mapjoin
