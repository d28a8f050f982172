// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/io/g2o/lines.hpp>
#include <mapjoin/io/g2o/tags.hpp>
#include <mapjoin/model/information.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
class LineReader {
 public:
  LineReader(TextScanner text, const ReadOptions& options, const Expected<G2oOffsets>& offsets)
      : text_(std::move(text)), options_(options), offsets_(offsets), check_(options.repair_information) {}

  G2oLines<Dim> read() {
    while (text_.next_line()) {
      const auto line = read_line(text_.word());
      if (line) continue;
      read_.fault = line.error();
      break;
    }
    read_.repairs = check_.repairs();
    return std::move(read_);
  }

 private:
  using Tags = G2oTags<Dim>;

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
    return finish(G2oPoseVertex<Dim>{place, id, pose});
  }

  Expected<void> read_feature_vertex() {
    const Place place = text_.place();
    const FeatureId id{text_.key()};
    const Point<Dim> point = text_.vector<Dim>();
    return finish(G2oFeatureVertex<Dim>{place, id, point});
  }

  Expected<void> read_fix() {
    G2oFix fix;
    do {
      fix.ids.push_back({0, text_.key()});
    } while (!text_.at_end_of_line());
    return finish(std::move(fix));
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
    if (const auto fault = check_.fault(W)) return unfit(place, base.key, target.key, *fault);
    read_.lines.push_back(G2oPoseEdge<Dim>{base, target, measured, W});
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
    if (const auto fault = check_.fault(W)) return unfit(place, pose.key, feature.key, *fault);
    const Point<Dim> measured = transform(*sensor, seen);
    if (!measured.allFinite()) return text_.error(place, fmt::format("{} is too far away", to_string(feature)));
    read_.lines.push_back(G2oObservation<Dim>{pose, feature, measured, W});
    return {};
  }

  /// The pose of the sensor in the frame of the robot's pose, which an observation in space names.
  Expected<Pose<Dim>> read_sensor() {
    if constexpr (Dim == 2) {
      return Pose<2>{};
    } else {
      if (!offsets_) return tl::unexpected(offsets_.error());
      const std::uint64_t key = text_.key();
      const auto offset = offsets_->find(key);
      if (offset != offsets_->end()) return offset->second;
      text_.reject(fmt::format("no {} line gives the sensor offset {}", kG2oOffset, key));
      return Pose<3>{};
    }
  }

  tl::unexpected<Error> unfit(const Place& place, std::uint64_t from, std::uint64_t to, const std::string& fault) const {
    return text_.error(place, fmt::format("the information matrix of edge {}-{} {}", from, to, fault));
  }

  template <typename Line>
  Expected<void> finish(Line line) {
    if (auto end = text_.finish_line(); !end) return end;
    read_.lines.push_back(std::move(line));
    return {};
  }

  TextScanner text_;
  const ReadOptions& options_;
  const Expected<G2oOffsets>& offsets_;
  InformationCheck check_;
  G2oLines<Dim> read_;
};

}  // namespace

template <int Dim>
G2oLines<Dim> read_g2o_lines(TextScanner piece, const ReadOptions& options, const Expected<G2oOffsets>& offsets) {
  return LineReader<Dim>(std::move(piece), options, offsets).read();
}

template G2oLines<2> read_g2o_lines(TextScanner, const ReadOptions&, const Expected<G2oOffsets>&);
template G2oLines<3> read_g2o_lines(TextScanner, const ReadOptions&, const Expected<G2oOffsets>&);

}  // namespace mapjoin
