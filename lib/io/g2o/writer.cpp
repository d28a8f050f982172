// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/text_line.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/g2o/numbering.hpp>
#include <mapjoin/io/g2o/tags.hpp>
#include <stdexcept>
#include <utility>

namespace mapjoin {
namespace {

tl::unexpected<Error> not_in_g2o(const std::string& message) {
  return tl::unexpected(Error{ErrorKind::kUsage, message});
}

/// Writes the parts of a g2o file; names by index come from the lists it was made with.
template <int Dim>
class G2oWriter {
 public:
  static Expected<G2oWriter> create(const std::filesystem::path& path, const std::vector<PoseId>& poses,
                                    const std::vector<FeatureId>& features) {
    const auto numbering = number_for_g2o(poses, features);
    if (!numbering) return tl::unexpected(numbering.error());
    auto file = OutputFile::create(path);
    if (!file) return tl::unexpected(file.error());
    return G2oWriter(*std::move(file), *numbering, poses, features);
  }

  void write_comments() {
    comment("Information matrices weigh the difference between measured and predicted relative pose:");
    comment(Dim == 2 ? "translation in the frame of the first pose, then heading."
                     : "translation in the frame of the first pose, then the rotation vector (not the quaternion).");
    comment(
        "One numbering: keys of features and of sessions beyond the first are moved by a power of ten where they met others.");
  }

  void write_vertices(const std::vector<Pose<Dim>>& poses, const std::vector<Point<Dim>>& features) {
    write_each(poses.size(),
               [&](TextLine& line, std::size_t i) { line.add(Tags::kPose).add(numbering_(pose_ids_[i])).add(poses[i]); });
    write_each(features.size(), [&](TextLine& line, std::size_t i) {
      line.add(Tags::kFeature).add(numbering_(feature_ids_[i])).template add<Dim>(features[i]);
    });
  }

  void write_fix(Index pose) { line_.add(kG2oFix).add(pose_number(pose)).write_to(file_); }

  void write_edges(const Log<Dim>& log) {
    write_pose_edges(log.edges());
    if (Dim == 3 && !log.observations().empty()) line_.add(kG2oOffset).add(kOffset).add(Pose<Dim>{}).write_to(file_);
    write_each(log.observations().size(), [&](TextLine& line, std::size_t k) {
      const FeatureFactor<Dim>& o = log.observations()[k];
      const FeatureId feature = feature_ids_[static_cast<std::size_t>(o.target)];
      line.add(Tags::kObservation).add(pose_number(o.base)).add(numbering_(feature));
      if (Dim == 3) line.add(kOffset);
      line.template add<Dim>(o.measured).template add_symmetric<Dim>(o.information);
    });
  }

  Expected<void> commit() { return file_.commit(); }

 private:
  using Tags = G2oTags<Dim>;
  static constexpr char kSeparator = ' ';
  static constexpr int kOffset = 0;  ///< The id of the one sensor offset, which is the identity.

  G2oWriter(OutputFile file, const G2oNumbering& numbering, const std::vector<PoseId>& poses,
            const std::vector<FeatureId>& features)
      : file_(std::move(file)), numbering_(numbering), pose_ids_(poses), feature_ids_(features) {}

  template <typename Fill>
  void write_each(std::size_t count, Fill&& fill) {
    write_lines(file_, kSeparator, count, fill);
  }
  void comment(const std::string& text) { line_.add("#").add(text).write_to(file_); }

  std::uint64_t pose_number(Index pose) const { return numbering_(pose_ids_[static_cast<std::size_t>(pose)]); }

  void write_pose_edges(std::span<const PoseFactor<Dim>> edges) {
    write_each(edges.size(), [&](TextLine& line, std::size_t k) {
      const PoseFactor<Dim>& edge = edges[k];
      line.add(Tags::kPoseEdge).add(pose_number(edge.base)).add(pose_number(edge.target));
      line.add(edge.measured).template add_symmetric<kPoseDof<Dim>>(edge.information);
    });
  }

  OutputFile file_;
  G2oNumbering numbering_;
  const std::vector<PoseId>& pose_ids_;
  const std::vector<FeatureId>& feature_ids_;
  TextLine line_{kSeparator};
};

/// The vertices of a log, fixed poses at the value they are fixed at; none unless every pose and feature has an initial value.
template <int Dim>
std::vector<Pose<Dim>> pose_vertices(const Log<Dim>& log) {
  if (log.initial.features.size() < log.features.size()) return {};
  std::vector<Pose<Dim>> poses = log.initial.poses;
  if (poses.empty()) return poses;
  for (const FixedPose<Dim>& fixed : log.graph.fixed) poses[static_cast<std::size_t>(fixed.pose)] = fixed.value;
  return poses;
}

template <int Dim>
Expected<void> check_expressible(const Log<Dim>& log, bool has_vertices) {
  const std::size_t priors = log.pose_priors().size() + log.feature_priors().size();
  if (priors > 0) return not_in_g2o(fmt::format("g2o files cannot hold the {} priors of this log", priors));
  for (const FixedPose<Dim>& fixed : log.graph.fixed) {
    if (has_vertices || local(fixed.value, Pose<Dim>{}).isZero(0.0)) continue;
    return not_in_g2o(
        fmt::format("g2o files cannot fix {} away from the origin without initial values of every pose and feature",
                    to_string(log.poses[static_cast<std::size_t>(fixed.pose)])));
  }
  return {};
}

}  // namespace

template <int Dim>
Expected<void> write_g2o(const Log<Dim>& log, const std::filesystem::path& path) {
  const std::vector<Pose<Dim>> poses = pose_vertices(log);
  if (auto expressible = check_expressible(log, !poses.empty()); !expressible) return expressible;
  auto writer = G2oWriter<Dim>::create(path, log.poses, log.features);
  if (!writer) return tl::unexpected(writer.error());
  writer->write_comments();
  if (!poses.empty()) writer->write_vertices(poses, log.initial.features);
  for (const FixedPose<Dim>& fixed : log.graph.fixed) writer->write_fix(fixed.pose);
  writer->write_edges(log);
  return writer->commit();
}

template <int Dim>
Expected<void> write_g2o(const GlobalMap<Dim>& map, const Log<Dim>* log, const std::filesystem::path& path) {
  if (log && (log->poses != map.pose_ids || log->features != map.feature_ids)) {
    throw std::invalid_argument("write_g2o: the log is over other poses or features than the map");
  }
  auto writer = G2oWriter<Dim>::create(path, map.pose_ids, map.feature_ids);
  if (!writer) return tl::unexpected(writer.error());
  writer->write_comments();
  writer->write_vertices(map.poses, map.features);
  for (const Index pose : map.gauge) writer->write_fix(pose);
  if (log) writer->write_edges(*log);
  return writer->commit();
}

template Expected<void> write_g2o(const Log<2>&, const std::filesystem::path&);
template Expected<void> write_g2o(const Log<3>&, const std::filesystem::path&);
template Expected<void> write_g2o(const GlobalMap<2>&, const Log<2>*, const std::filesystem::path&);
template Expected<void> write_g2o(const GlobalMap<3>&, const Log<3>*, const std::filesystem::path&);

}  // namespace mapjoin
