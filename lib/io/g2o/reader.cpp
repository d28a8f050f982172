// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/io/g2o/declarations.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/g2o/lines.hpp>
#include <mapjoin/io/g2o/tags.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <numeric>
#include <utility>
#include <variant>
#include <vector>

namespace mapjoin {
namespace {

/// Pieces of a file are read side by side, so many at once; what they say is taken in their order.
constexpr std::size_t kPieceBytes = 1 << 16;
constexpr std::size_t kPiecesAtOnce = 64;

struct Extent {
  bool is_whole = true;  ///< Else some lines of a file.
  std::size_t piece_bytes = kPieceBytes;
};

template <int Dim>
class G2oReader {
 public:
  G2oReader(const TextScanner& text, const ReadOptions& options, Extent extent)
      : begin_(text),
        options_(options),
        extent_(extent),
        builder_(begin_.source(),
                 {.pose_error = options.pose_error,
                  .rotation_information = Dim == 3 ? options.rotation_information : RotationInformation::kVector},
                 Numbers::kChecked) {}

  Expected<Log<Dim>> read() {
    const std::vector<TextScanner> pieces = begin_.pieces(extent_.piece_bytes);
    const bool sees_features = make_room(pieces);
    const Expected<G2oOffsets> offsets = Dim == 3 && sees_features ? read_g2o_offsets(begin_) : G2oOffsets{};
    if (auto taken = read_and_take(pieces, offsets); !taken) return tl::unexpected(taken.error());
    if (auto declared = check_declarations(); !declared) return tl::unexpected(declared.error());
    auto log = std::move(builder_).finish();
    if (log) log->conventions.repairs = repairs_;
    if (log && extent_.is_whole && has_vertices() &&
        (log->poses.size() > poses_.size() || log->features.size() > features_.size())) {
      return tl::unexpected(undeclared());
    }
    return log;
  }

 private:
  using Tags = G2oTags<Dim>;

  /// Growing the vectors of a large log costs as much as reading it. A count is believed as far as so many lines that are
  /// complete, of two bytes a number at least, fit into the file. Returns whether there are observations of features.
  bool make_room(const std::vector<TextScanner>& pieces) {
    std::vector<std::size_t> pose_edges(pieces.size());
    std::vector<std::size_t> observations(pieces.size());
    parallel_for(pieces.size(), [&](std::size_t k) {
      for (TextScanner ahead = pieces[k]; ahead.next_line();) {
        const std::string_view tag = ahead.word();
        if (tag == Tags::kPoseEdge) ++pose_edges[k];
        if (tag == Tags::kObservation) ++observations[k];
      }
    });
    const auto count = [&](const std::vector<std::size_t>& counts, int dof) {
      const auto bytes = static_cast<std::size_t>(2 * (2 + dof + dof * (dof + 1) / 2));
      return std::min(std::accumulate(counts.begin(), counts.end(), std::size_t{0}), begin_.size() / bytes);
    };
    const std::size_t observed = count(observations, Dim);
    builder_.reserve(count(pose_edges, kPoseDof<Dim>), observed);
    return observed > 0;
  }

  /// What a piece says is taken while later ones are read.
  Expected<void> read_and_take(const std::vector<TextScanner>& pieces, const Expected<G2oOffsets>& offsets) {
    std::vector<G2oLines<Dim>> read(pieces.size());
    Expected<void> taken;
    parallel_in_order(
        pieces.size(), kPiecesAtOnce, [&](std::size_t k) { read[k] = read_g2o_lines<Dim>(pieces[k], options_, offsets); },
        [&](std::size_t k) {
          taken = take(std::exchange(read[k], {}));
          return taken.has_value();
        });
    return taken;
  }

  Expected<void> take(const G2oLines<Dim>& piece) {
    for (const auto& line : piece.lines) std::visit([this](const auto& known) { this->take(known); }, line);
    repairs_ += piece.repairs;
    return piece.fault ? tl::unexpected(*piece.fault) : Expected<void>();
  }

  void take(const G2oPoseVertex<Dim>& vertex) {
    poses_.add(vertex.id.key, vertex.place);
    builder_.add_pose(vertex.id, vertex.pose);
  }
  void take(const G2oFeatureVertex<Dim>& vertex) {
    features_.add(vertex.id.key, vertex.place);
    builder_.add_feature(vertex.id, vertex.point);
  }
  void take(const G2oFix& fix) {
    if (!extent_.is_whole) return;
    for (const PoseId& id : fix.ids) builder_.fix(id);
  }
  void take(const G2oPoseEdge<Dim>& edge) { builder_.add_pose_edge(edge.base, edge.target, edge.measured, edge.information); }
  void take(const G2oObservation<Dim>& seen) {
    builder_.add_observation(seen.pose, seen.feature, seen.measured, seen.information);
  }

  bool has_vertices() const { return poses_.size() + features_.size() > 0; }

  Expected<void> check_declarations() {
    poses_.sort();
    features_.sort();
    if (const auto twice = poses_.repetition()) {
      return begin_.error(twice->place, fmt::format("pose {} is declared a second time", twice->key));
    }
    if (const auto twice = features_.repetition()) {
      return begin_.error(twice->place, fmt::format("feature {} is declared a second time", twice->key));
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
  ReadOptions options_;
  Extent extent_;
  LogBuilder<Dim> builder_;
  G2oDeclarations poses_;
  G2oDeclarations features_;
  MatrixRepairs repairs_;
};

template <int Dim>
Expected<AnyLog> read(const TextScanner& text, const ReadOptions& options, Extent extent) {
  auto log = G2oReader<Dim>(text, options, extent).read();
  if (!log) return tl::unexpected(log.error());
  return AnyLog(*std::move(log));
}

Expected<AnyLog> read(const TextScanner& text, const ReadOptions& options, Extent extent) {
  for (TextScanner ahead = text; ahead.next_line();) {
    const std::string_view tag = ahead.word();
    if (is_g2o_tag_of<2>(tag)) return read<2>(text, options, extent);
    if (is_g2o_tag_of<3>(tag)) return read<3>(text, options, extent);
    if (!is_g2o_tag(tag)) return ahead.error(fmt::format("unknown tag {}", in_quotes(tag)));
  }
  return bad_input(fmt::format("{}: the log has no poses", text.source()));
}

}  // namespace

bool is_g2o_tag(std::string_view tag) {
  return is_g2o_tag_of<2>(tag) || is_g2o_tag_of<3>(tag) || tag == kG2oFix || is_g2o_parameter(tag);
}

Expected<AnyLog> read_g2o(TextScanner text, const ReadOptions& options) {
  return read(text, options, {});
}

Expected<AnyLog> read_g2o_in_pieces(TextScanner text, const ReadOptions& options, std::size_t piece_bytes) {
  return read(text, options, {.piece_bytes = piece_bytes});
}

Expected<AnyLog> read_g2o_part(TextScanner text, const ReadOptions& options) {
  return read(text, options, {.is_whole = false});
}

}  // namespace mapjoin
