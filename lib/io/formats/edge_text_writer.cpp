// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/io/formats/edge_text.hpp>
#include <mapjoin/io/g2o/numbering.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
class EdgeTextWriter {
 public:
  EdgeTextWriter(const EdgeTextContents<Dim>& contents, const EdgeText<Dim>& format, const G2oNumbering& numbering,
                 OutputFile file)
      : contents_(contents), format_(format), numbering_(numbering), file_(std::move(file)) {}

  Expected<void> write() && {
    for (const std::string& comment : contents_.comments) line_.add("#").add(comment).write_to(file_);
    if (contents_.poses) write_poses(*contents_.poses);
    if (contents_.features) write_features(*contents_.features);
    for (const PoseIndex pose : contents_.fixed) line_.add(kG2oFix).add(numbering_(pose_id(pose))).write_to(file_);
    if (contents_.log) write_edges(contents_.log->edges());
    if (contents_.log) write_observations(contents_.log->observations());
    if (contents_.log && !format_.priors.empty()) write_priors(*contents_.log);
    if (!fault_) return file_.commit();
    return tl::unexpected(
        Error{ErrorKind::kUsage, fmt::format("{}: {}, which {} cannot say", contents_.source, *fault_, format_.name)});
  }

 private:
  const PoseId& pose_id(PoseIndex pose) const { return contents_.pose_ids[pose]; }

  /// Writes a line for every k in [0, count), in order; pieces of them are filled in parallel, and written by this thread,
  /// whose writes a signal ends. `put(line, k)` gives the fault of a line that the format cannot express; the first fault
  /// counts.
  template <typename Put>
  void write_each(std::size_t count, const Put& put) {
    constexpr std::size_t kLines = 500;  // Per piece.
    constexpr std::size_t kPiecesAtOnce = 16;
    struct Piece {
      std::string text;
      Fault fault;
    };
    for (std::size_t begin = 0; begin < count && !fault_; begin += kPiecesAtOnce * kLines) {
      const std::size_t end = std::min(count, begin + kPiecesAtOnce * kLines);
      std::vector<Piece> pieces((end - begin + kLines - 1) / kLines);
      parallel_for(pieces.size(), [&](std::size_t p) {
        TextLine line(' ');
        const std::size_t first = begin + p * kLines;
        for (std::size_t k = first; k < std::min(end, first + kLines) && !pieces[p].fault; ++k) {
          pieces[p].fault = put(line, k);
          line.append_to(pieces[p].text);
        }
      });
      for (auto piece = pieces.begin(); piece != pieces.end() && !fault_; ++piece) {
        file_.write(piece->text);
        fault_ = piece->fault;
      }
    }
  }

  template <typename Measured>
  Fault put_measured(Measured measured, Fault (*put)(const Measured&, TextLine&), TextLine& line) const {
    auto& W = measured.information;
    const Fault fault = format_.weights == Weights::kCovariance ? covariance_of(W, W) : std::nullopt;
    return fault ? fault : put(measured, line);
  }

  void write_poses(const Table<PoseIndex, Pose<Dim>>& poses) {
    write_each(poses.size(), [&](TextLine& line, std::size_t k) -> Fault {
      const PoseIndex pose(k);
      const PoseId& id = pose_id(pose);
      const auto fault = format_.put_pose(poses[pose], line.add(format_.pose_tag).add(numbering_(id)));
      return fault ? to_string(id) + " " + *fault : fault;
    });
  }

  void write_features(const Table<FeatureIndex, Point<Dim>>& features) {
    write_each(features.size(), [&](TextLine& line, std::size_t k) -> Fault {
      const FeatureIndex feature(k);
      line.add(format_.feature_tag).add(numbering_(contents_.feature_ids[feature])).template add<Dim>(features[feature]);
      return std::nullopt;
    });
  }

  void write_edges(std::span<const PoseFactor<Dim>> edges) {
    write_each(edges.size(), [&](TextLine& line, std::size_t k) -> Fault {
      const PoseId& base = pose_id(edges[k].base);
      const PoseId& target = pose_id(edges[k].target);
      line.add(format_.edge_tag).add(numbering_(base)).add(numbering_(target));
      const auto fault = put_measured(MeasuredPose<Dim>{edges[k].measured, edges[k].information}, format_.put_edge, line);
      return fault ? name_of(base, target) + " " + *fault : fault;
    });
  }

  void write_observations(std::span<const FeatureFactor<Dim>> observations) {
    if (format_.observation_tag.empty() || observations.empty()) return;
    write_offset_line();
    write_each(observations.size(), [&](TextLine& line, std::size_t k) -> Fault {
      const FeatureFactor<Dim>& seen = observations[k];
      const PoseId& pose = pose_id(seen.base);
      const FeatureId feature = contents_.feature_ids[seen.target];
      line.add(format_.observation_tag).add(numbering_(pose)).add(numbering_(feature));
      const auto fault = put_measured(MeasuredPoint<Dim>{seen.measured, seen.information}, format_.put_point, line);
      return fault ? name_of(pose, feature) + " " + *fault : fault;
    });
  }

  /// Writes the sensor offset that observations and priors name, once.
  void write_offset_line() {
    if (!format_.offset_line.empty() && !has_offset_) line_.add(format_.offset_line).write_to(file_);
    has_offset_ = true;
  }

  /// The prior without its lever; nullopt if it has a lever and its pose no value at which to take that off.
  std::optional<PoseFactor<Dim>> without_lever(const PoseFactor<Dim>& prior) const {
    if (prior.lever.isZero(0.0)) return prior;
    if (!contents_.poses || contents_.poses->empty()) return std::nullopt;
    return mapjoin::without_lever(prior, (*contents_.poses)[prior.target]);
  }

  /// Writes the priors, those of poses as priors of the whole pose, whatever part of it was measured.
  void write_priors(const Log<Dim>& log) {
    const auto pose_priors = log.pose_priors();
    if (!pose_priors.empty()) write_offset_line();
    write_each(pose_priors.size(), [&](TextLine& line, std::size_t k) -> Fault {
      const auto prior = without_lever(pose_priors[k]);
      if (!prior) {
        return fmt::format("the prior of {} has a lever and its pose no value", to_string(pose_id(pose_priors[k].target)));
      }
      begin_prior(PriorTag::Kind::kPose, numbering_(pose_id(prior->target)), line);
      return format_.put_edge({prior->measured, prior->information}, line);
    });
    const auto feature_priors = log.feature_priors();
    write_each(feature_priors.size(), [&](TextLine& line, std::size_t k) -> Fault {
      const FeatureFactor<Dim>& prior = feature_priors[k];
      begin_prior(PriorTag::Kind::kFeature, numbering_(contents_.feature_ids[prior.target]), line);
      return put_plain_point<Dim>({prior.measured, prior.information}, line);
    });
  }

  void begin_prior(PriorTag::Kind kind, std::uint64_t id, TextLine& line) const {
    const PriorTag& prior = *std::ranges::find(format_.priors, kind, &PriorTag::kind);
    line.add(prior.tag).add(id);
    if (prior.sensor != PriorTag::Sensor::kNone) line.add(0);
  }

  const EdgeTextContents<Dim>& contents_;
  const EdgeText<Dim>& format_;
  G2oNumbering numbering_;
  OutputFile file_;
  TextLine line_{' '};
  Fault fault_;
  bool has_offset_ = false;
};

}  // namespace

template <int Size>
Fault covariance_of(const Matrix<Size>& information, Matrix<Size>& covariance) {
  const auto inverse = information_of_covariance<Size>(information);
  // A covariance that readers would refuse is none.
  if (!inverse || !information_of_covariance<Size>(*inverse)) {
    return "has an information matrix that is singular, and so no covariance";
  }
  covariance = *inverse;
  return std::nullopt;
}

template <int Dim>
Expected<void> write_edge_text(const EdgeTextContents<Dim>& contents, const EdgeText<Dim>& format,
                               const std::filesystem::path& path) {
  const auto numbering = number_for_g2o(contents.pose_ids, format.one_numbering ? contents.feature_ids : FeatureIds());
  if (!numbering) return tl::unexpected(numbering.error());
  return OutputFile::create(path).and_then(
      [&](OutputFile&& file) { return EdgeTextWriter<Dim>(contents, format, *numbering, std::move(file)).write(); });
}

template <int Dim>
Expected<void> write_edge_text(const Log<Dim>& log, const EdgeText<Dim>& format, const std::filesystem::path& path) {
  EdgeTextContents<Dim> contents{log.source, log.poses, log.features, {std::string(format.comment)}};
  contents.log = &log;
  if (!format.pose_tag.empty()) contents.poses = &log.initial.poses;
  if (contents.poses && contents.poses->empty()) {
    return tl::unexpected(Error{ErrorKind::kUsage, fmt::format("{}: the log has no values of its poses, which {} cannot say",
                                                               log.source, format.name)});
  }
  return write_edge_text(contents, format, path);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                             \
  template Expected<void> write_edge_text(const EdgeTextContents<Dim>&, const EdgeText<Dim>&, const std::filesystem::path&); \
  template Expected<void> write_edge_text(const Log<Dim>&, const EdgeText<Dim>&, const std::filesystem::path&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE
template Fault covariance_of(const Matrix<2>&, Matrix<2>&);
template Fault covariance_of(const Matrix<3>&, Matrix<3>&);
template Fault covariance_of(const Matrix<6>&, Matrix<6>&);
template Fault covariance_of(const Matrix<Eigen::Dynamic>&, Matrix<Eigen::Dynamic>&);

}  // namespace mapjoin
