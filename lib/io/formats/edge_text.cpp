// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/formats/edge_text.hpp>
#include <mapjoin/io/g2o/declarations.hpp>
#include <mapjoin/io/g2o/numbering.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
class EdgeTextReader {
 public:
  EdgeTextReader(TextScanner text, const EdgeText<Dim>& format, const ReadOptions& options)
      : text_(std::move(text)), format_(format), check_(options.repair_information), builder_(text_.source()) {}

  Expected<AnyLog> read() {
    while (text_.next_line()) {
      if (auto line = read_line(text_.word()); !line) return tl::unexpected(line.error());
    }
    if (auto declared = check_declared(); !declared) return tl::unexpected(declared.error());
    auto log = std::move(builder_).finish();
    if (!log) return tl::unexpected(log.error());
    log->conventions.repairs = check_.repairs();
    return AnyLog(*std::move(log));
  }

 private:
  Expected<void> read_line(std::string_view tag) {
    if (tag == format_.edge_tag) return read_edge();
    if (!format_.observation_tag.empty() && tag == format_.observation_tag) return read_observation();
    if (!format_.pose_tag.empty() && tag == format_.pose_tag) return read_pose();
    return text_.error(fmt::format("unknown tag {}", in_quotes(tag)));
  }

  Expected<void> read_edge() {
    const Place place = text_.place();
    const PoseId base{0, text_.key()};
    const PoseId target{0, text_.key()};
    MeasuredPose<Dim> edge = format_.read_edge(text_, check_);
    if (auto line = text_.finish_line(); !line) return line;
    if (base == target) return text_.error(place, fmt::format("an edge leads from {} to itself", to_string(base)));
    if (const auto fault = check_.fault(edge.information)) return faulty(place, base.key, target.key, *fault);
    if (!format_.pose_tag.empty()) named_.push_back({place, base.key, target.key});
    builder_.add_pose_edge(base, target, edge.measured, edge.information);
    return {};
  }

  Expected<void> read_observation() {
    const Place place = text_.place();
    const PoseId pose{0, text_.key()};
    const FeatureId feature{text_.key()};
    MeasuredPoint<Dim> point = format_.read_point(text_, check_);
    if (auto line = text_.finish_line(); !line) return line;
    if (const auto fault = check_.fault(point.information)) return faulty(place, pose.key, feature.key, *fault);
    builder_.add_observation(pose, feature, point.measured, point.information);
    return {};
  }

  Expected<void> read_pose() {
    const Place place = text_.place();
    const PoseId id{0, text_.key()};
    const Pose<Dim> pose = format_.read_pose(text_);
    declared_.add(id.key, place);
    builder_.add_pose(id, pose);
    return text_.finish_line();
  }

  tl::unexpected<Error> faulty(const Place& place, std::uint64_t base, std::uint64_t target, const std::string& fault) const {
    return text_.error(place, fmt::format("the information matrix of edge {}-{} {}", base, target, fault));
  }

  Expected<void> check_declared() {
    declared_.sort();
    if (const auto twice = declared_.repetition()) {
      return text_.error(twice->place, fmt::format("pose {} is declared a second time", twice->key));
    }
    if (declared_.size() == 0) return {};
    for (const auto& [place, base, target] : named_) {
      if (declared_.contains(base) && declared_.contains(target)) continue;
      const PoseId missing{0, declared_.contains(base) ? target : base};
      return text_.error(place, fmt::format("the file declares vertices, but not {}", to_string(missing)));
    }
    return {};
  }

  struct Named {
    Place place;
    std::uint64_t base;
    std::uint64_t target;
  };

  TextScanner text_;
  const EdgeText<Dim>& format_;
  InformationCheck check_;
  LogBuilder<Dim> builder_;
  G2oDeclarations declared_;
  std::vector<Named> named_;  ///< By the edges, where the format declares poses.
};

template <int Dim>
class EdgeTextWriter {
 public:
  EdgeTextWriter(const Log<Dim>& log, const EdgeText<Dim>& format, const G2oNumbering& numbering, OutputFile file)
      : log_(log), format_(format), numbering_(numbering), file_(std::move(file)) {}

  Expected<void> write() {
    line_.add("#").add(format_.comment).write_to(file_);
    return write_poses()
        .and_then([&] { return write_edges(log_.edges()); })
        .and_then([&] { return write_observations(); })
        .and_then([&] { return file_.commit(); });
  }

 private:
  tl::unexpected<Error> not_in_format(const std::string& what, const std::string& fault) const {
    return tl::unexpected(
        Error{ErrorKind::kUsage, fmt::format("{}: {} {}, which {} cannot say", log_.source, what, fault, format_.name)});
  }
  PoseId pose(Index index) const { return log_.poses[static_cast<std::size_t>(index)]; }

  Expected<void> write_poses() {
    if (format_.pose_tag.empty()) return {};
    if (log_.initial.poses.empty()) return not_in_format("the log", "has no values of its poses");
    for (std::size_t i = 0; i < log_.poses.size(); ++i) {
      line_.add(format_.pose_tag).add(numbering_(log_.poses[i]));
      if (const Fault fault = format_.put_pose(log_.initial.poses[i], line_))
        return not_in_format(to_string(log_.poses[i]), *fault);
      line_.write_to(file_);
    }
    return {};
  }

  Expected<void> write_edges(std::span<const PoseFactor<Dim>> edges) {
    for (const PoseFactor<Dim>& edge : edges) {
      line_.add(format_.edge_tag).add(numbering_(pose(edge.base))).add(numbering_(pose(edge.target)));
      if (const Fault fault = format_.put_edge({edge.measured, edge.information}, line_)) {
        return not_in_format(fmt::format("the edge from {} to {}", to_string(pose(edge.base)), to_string(pose(edge.target))),
                             *fault);
      }
      line_.write_to(file_);
    }
    return {};
  }

  Expected<void> write_observations() {
    if (format_.observation_tag.empty()) return {};
    for (const FeatureFactor<Dim>& o : log_.observations()) {
      const FeatureId feature = log_.features[static_cast<std::size_t>(o.target)];
      line_.add(format_.observation_tag).add(numbering_(pose(o.base))).add(numbering_(feature));
      if (const Fault fault = format_.put_point({o.measured, o.information}, line_)) {
        return not_in_format(fmt::format("the observation of {} from {}", to_string(feature), to_string(pose(o.base))), *fault);
      }
      line_.write_to(file_);
    }
    return {};
  }

  const Log<Dim>& log_;
  const EdgeText<Dim>& format_;
  G2oNumbering numbering_;
  OutputFile file_;
  TextLine line_{' '};
};

}  // namespace

template <int Dim>
Expected<AnyLog> read_edge_text(TextScanner text, const EdgeText<Dim>& format, const ReadOptions& options) {
  return EdgeTextReader<Dim>(std::move(text), format, options).read();
}

template <int Dim>
Expected<void> write_edge_text(const Log<Dim>& log, const EdgeText<Dim>& format, const std::filesystem::path& path) {
  const auto numbering = number_for_g2o(log.poses, format.one_numbering ? log.features : std::vector<FeatureId>());
  if (!numbering) return tl::unexpected(numbering.error());
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  return EdgeTextWriter<Dim>(log, format, *numbering, *std::move(file)).write();
}

template Expected<AnyLog> read_edge_text(TextScanner, const EdgeText<2>&, const ReadOptions&);
template Expected<AnyLog> read_edge_text(TextScanner, const EdgeText<3>&, const ReadOptions&);
template Expected<void> write_edge_text(const Log<2>&, const EdgeText<2>&, const std::filesystem::path&);
template Expected<void> write_edge_text(const Log<3>&, const EdgeText<3>&, const std::filesystem::path&);

}  // namespace mapjoin
