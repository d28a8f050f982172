// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/io/g2o.hpp>
#include <mapjoin/io/g2o_declarations.hpp>
#include <mapjoin/io/g2o_fields.hpp>
#include <mapjoin/io/g2o_information.hpp>
#include <mapjoin/io/g2o_part.hpp>
#include <mapjoin/io/g2o_tags.hpp>
#include <mapjoin/io/information.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

enum class Extent : std::uint8_t { kWhole, kPart };

template <int Dim>
class G2oReader {
 public:
  G2oReader(TextScanner text, const ReadOptions& options, Extent extent)
      : begin_(text),
        text_(std::move(text)),
        options_(options),
        extent_(extent),
        check_(options.repair_information),
        builder_(begin_.source(),
                 {.pose_error = options.pose_error,
                  .rotation_information = Dim == 3 ? options.rotation_information : RotationInformation::kVector}) {}

  Expected<Log<Dim>> read() {
    make_room();
    while (text_.next_line()) {
      if (auto line = read_line(text_.word()); !line) return tl::unexpected(line.error());
    }
    if (auto declared = check_declarations(); !declared) return tl::unexpected(declared.error());
    auto log = std::move(builder_).finish();
    if (log) log->conventions.repaired_informations = check_.repaired();
    if (log && extent_ == Extent::kWhole && has_vertices() &&
        (log->poses.size() > poses_.size() || log->features.size() > features_.size())) {
      return tl::unexpected(undeclared());
    }
    return log;
  }

 private:
  using Tags = G2oTags<Dim>;

  /// Growing the vectors of a large log costs as much as reading it. A count is believed as far as so many lines that are
  /// complete, of two bytes a number at least, fit into the file.
  void make_room() {
    std::size_t pose_edges = 0;
    std::size_t observations = 0;
    for (TextScanner ahead = text_; ahead.next_line();) {
      const std::string_view tag = ahead.word();
      if (tag == Tags::kPoseEdge) ++pose_edges;
      if (tag == Tags::kObservation) ++observations;
    }
    const auto bytes = [](int dof) { return static_cast<std::size_t>(2 * (2 + dof + dof * (dof + 1) / 2)); };
    builder_.reserve(std::min(pose_edges, text_.size() / bytes(kPoseDof<Dim>)),
                     std::min(observations, text_.size() / bytes(Dim)));
  }

  Expected<void> read_line(std::string_view tag) {
    if (tag == Tags::kPoseEdge) return read_pose_edge();
    if (tag == Tags::kObservation) return read_observation();
    if (tag == Tags::kPose) return read_pose_vertex();
    if (tag == Tags::kFeature) return read_feature_vertex();
    if (tag == kG2oFix) return read_fix();
    if (is_g2o_parameter(tag)) return {};
    if (is_g2o_tag_of<5 - Dim>(tag)) return text_.error(fmt::format("{} in a file of dimension {}", tag, Dim));
    return text_.error(fmt::format("unknown tag {}", in_quotes(tag)));
  }

  Expected<void> read_pose_vertex() {
    const Place place = text_.place();
    const PoseId id{0, text_.key()};
    const Pose<Dim> pose = read_g2o_pose<Dim>(text_);
    poses_.add(id.key, place);
    builder_.add_pose(id, pose);
    return text_.finish_line();
  }

  Expected<void> read_feature_vertex() {
    const Place place = text_.place();
    const FeatureId id{text_.key()};
    const Point<Dim> point = text_.vector<Dim>();
    features_.add(id.key, place);
    builder_.add_feature(id, point);
    return text_.finish_line();
  }

  Expected<void> read_fix() {
    do {
      const PoseId id{0, text_.key()};
      if (extent_ == Extent::kWhole) builder_.fix(id);
    } while (!text_.at_end_of_line());
    return text_.finish_line();
  }

  Expected<void> read_pose_edge() {
    const Place place = text_.place();
    const PoseId base{0, text_.key()};
    const PoseId target{0, text_.key()};
    const Pose<Dim> measured = read_g2o_pose<Dim>(text_);
    // Turned before it is checked: what passes here passes again where it is written and read back.
    PoseMatrix<Dim> W = from_g2o<Dim>(text_.symmetric<kPoseDof<Dim>>(), measured, options_);
    if (auto line = text_.finish_line(); !line) return line;
    if (base == target) return text_.error(place, fmt::format("an edge leads from {} to itself", to_string(base)));
    if (const auto fault = check_.fault(W)) {
      return text_.error(place, fmt::format("the information matrix of edge {}-{} {}", base.key, target.key, *fault));
    }
    builder_.add_pose_edge(base, target, measured, W);
    return {};
  }

  Expected<void> read_observation() {
    const Place place = text_.place();
    const PoseId pose{0, text_.key()};
    const FeatureId feature{text_.key()};
    const auto sensor = read_sensor();
    if (!sensor) return tl::unexpected(sensor.error());
    const Point<Dim> seen = text_.vector<Dim>();
    PointMatrix<Dim> W = turned_to_parent<Dim>(text_.symmetric<Dim>(), sensor->rotation);
    if (auto line = text_.finish_line(); !line) return line;
    if (const auto fault = check_.fault(W)) {
      return text_.error(place, fmt::format("the information matrix of edge {}-{} {}", pose.key, feature.key, *fault));
    }
    builder_.add_observation(pose, feature, transform(*sensor, seen), W);
    return {};
  }

  /// The pose of the sensor in the frame of the robot's pose, which an observation in space names.
  Expected<Pose<Dim>> read_sensor() {
    if constexpr (Dim == 2) {
      return Pose<2>{};
    } else {
      if (!offsets_) {
        auto offsets = read_g2o_offsets(begin_);
        if (!offsets) return tl::unexpected(offsets.error());
        offsets_ = *std::move(offsets);
      }
      const std::uint64_t key = text_.key();
      const auto offset = offsets_->find(key);
      if (offset != offsets_->end()) return offset->second;
      text_.reject(fmt::format("no {} line gives the sensor offset {}", kG2oOffset, key));
      return Pose<3>{};
    }
  }

  bool has_vertices() const { return poses_.size() + features_.size() > 0; }

  Expected<void> check_declarations() {
    poses_.sort();
    features_.sort();
    if (const auto twice = poses_.repetition()) {
      return text_.error(twice->place, fmt::format("pose {} is declared a second time", twice->key));
    }
    if (const auto twice = features_.repetition()) {
      return text_.error(twice->place, fmt::format("feature {} is declared a second time", twice->key));
    }
    return {};
  }

  /// In a second look at the file, the first edge to an id that no vertex declares.
  Error undeclared() const {
    for (TextScanner text = begin_; text.next_line();) {
      const std::string_view tag = text.word();
      const Place place = text.place();
      if (tag != Tags::kPoseEdge && tag != Tags::kObservation) continue;
      const std::uint64_t pose = text.key();
      const std::uint64_t target = text.key();
      const bool is_pose = tag == Tags::kPoseEdge;
      if (poses_.contains(pose) && (is_pose ? poses_ : features_).contains(target)) continue;
      const std::string missing = !poses_.contains(pose) ? to_string(PoseId{0, pose})
                                  : is_pose              ? to_string(PoseId{0, target})
                                                         : to_string(FeatureId{target});
      return text.error(place, fmt::format("the file declares vertices, but not {}", missing)).value();
    }
    return {};
  }

  TextScanner begin_;
  TextScanner text_;
  ReadOptions options_;
  Extent extent_;
  InformationCheck check_;
  LogBuilder<Dim> builder_;
  G2oDeclarations poses_;
  G2oDeclarations features_;
  std::optional<G2oOffsets> offsets_;  ///< Once an observation asks for one.
};

template <int Dim>
Expected<AnyLog> read(TextScanner text, const ReadOptions& options, Extent extent) {
  auto log = G2oReader<Dim>(std::move(text), options, extent).read();
  if (!log) return tl::unexpected(log.error());
  return AnyLog(*std::move(log));
}

Expected<AnyLog> read(TextScanner text, const ReadOptions& options, Extent extent) {
  for (TextScanner ahead = text; ahead.next_line();) {
    const std::string_view tag = ahead.word();
    if (is_g2o_tag_of<2>(tag)) return read<2>(std::move(text), options, extent);
    if (is_g2o_tag_of<3>(tag)) return read<3>(std::move(text), options, extent);
    if (!is_g2o_tag(tag)) return ahead.error(fmt::format("unknown tag {}", in_quotes(tag)));
  }
  return bad_input(fmt::format("{}: the log has no poses", text.source()));
}

}  // namespace

bool is_g2o_tag(std::string_view tag) {
  return is_g2o_tag_of<2>(tag) || is_g2o_tag_of<3>(tag) || tag == kG2oFix || is_g2o_parameter(tag);
}

Expected<AnyLog> read_g2o(TextScanner text, const ReadOptions& options) {
  return read(std::move(text), options, Extent::kWhole);
}

Expected<AnyLog> read_g2o_part(TextScanner text, const ReadOptions& options) {
  return read(std::move(text), options, Extent::kPart);
}

}  // namespace mapjoin
