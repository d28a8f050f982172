// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/io/formats/edge_text_piece.hpp>
#include <mapjoin/io/formats/undeclared.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/model/faults.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <numeric>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// The number of pieces of a file that are read in parallel; their contents are taken in order.
constexpr std::size_t kPiecesAtOnce = 64;

template <int Dim>
class EdgeTextReader {
 public:
  EdgeTextReader(TextScanner text, const EdgeText<Dim>& format, const ReadOptions& options, Extent extent)
      : begin_(std::move(text)),
        format_(format),
        context_{options, extent.is_whole, {}, {}},
        piece_bytes_(extent.piece_bytes),
        builder_(begin_.source(), format.has_g2o_lines ? g2o_conventions(options) : Conventions(), Numbers::kChecked) {
    if (!extent.needs_poses) builder_.allow_no_poses();
  }

  Expected<Log<Dim>> read() && {
    const std::vector<TextScanner> pieces = begin_.pieces(piece_bytes_);
    const bool names_sensors = make_room(pieces);
    if (Dim == 3 && format_.has_g2o_lines && names_sensors) {
      auto offsets = read_g2o_offsets(begin_);
      if (!offsets) return tl::unexpected(offsets.error());
      context_.offsets = *std::move(offsets);
    }
    if (auto taken = read_and_take(pieces); !taken) return tl::unexpected(taken.error());
    if (auto once = check_once(poses_, "pose").and_then([&] { return check_once(features_, "feature"); }); !once) {
      return tl::unexpected(once.error());
    }
    builder_.add_repairs({.missing = context_.unweighed});
    const bool is_to_come = context_.options.undeclared == Undeclared::kToCome;
    if (is_to_come) builder_.forget_loose();
    const bool has_vertices = context_.is_whole && !is_to_come && poses_.size() + features_.size() > 0;
    if (has_vertices && context_.options.undeclared != Undeclared::kSkipped && fixes_undeclared()) {
      return tl::unexpected(first_undeclared());
    }
    LeftOut<Dim> undeclared;
    if (has_vertices && context_.options.undeclared != Undeclared::kRefused) undeclared = builder_.take_undeclared();
    if (context_.options.undeclared == Undeclared::kForeign && undeclared.others > 0) return tl::unexpected(first_undeclared());
    if (context_.options.undeclared == Undeclared::kSkipped) {
      count_skipped(undeclared);
      undeclared.edges.clear();
    }
    if (auto fixed = is_to_come ? Expected<void>() : check_fixed(); !fixed) return tl::unexpected(fixed.error());
    return std::move(builder_).finish().and_then([&](Log<Dim>&& log) -> Expected<Log<Dim>> {
      if (has_vertices && (log.poses.size() > poses_.size() || log.features.size() > features_.size())) {
        return tl::unexpected(first_undeclared());
      }
      log.foreign = std::move(undeclared.edges);
      return std::move(log);
    });
  }

 private:
  static Conventions g2o_conventions(const ReadOptions& options) {
    return {.pose_error = options.pose_error,
            .rotation_information = Dim == 3 ? options.rotation_information : RotationInformation::kVector};
  }

  /// Reserves room for edges and observations, since growing the vectors of a large log costs as much as reading it. Counts are
  /// capped at the number of complete lines, of at least two bytes a number, that fit into the file. True if lines name
  /// sensors.
  bool make_room(const std::vector<TextScanner>& pieces) {
    std::vector<std::size_t> edges(pieces.size());
    std::vector<std::size_t> observations(pieces.size());
    std::atomic<bool> names_sensors = false;
    parallel_for(pieces.size(), [&](std::size_t k) {
      for (TextScanner ahead = pieces[k]; ahead.next_line();) {
        const std::string_view tag = ahead.word();
        if (tag == format_.edge_tag) ++edges[k];
        if (tag == format_.observation_tag) ++observations[k];
        const PriorTag* prior = format_.prior(tag);
        if (prior && prior->sensor == PriorTag::Sensor::kNamed) names_sensors = true;
      }
    });
    const auto count = [&](const std::vector<std::size_t>& counts, int dof) {
      const auto bytes = static_cast<std::size_t>(2 * (2 + dof + dof * (dof + 1) / 2));
      return std::min(std::accumulate(counts.begin(), counts.end(), std::size_t{0}), begin_.size() / bytes);
    };
    const std::size_t observed = count(observations, Dim);
    builder_.reserve(count(edges, kPoseDof<Dim>), observed);
    return names_sensors || observed > 0;
  }

  /// Reads pieces in parallel, and takes their contents in order meanwhile.
  Expected<void> read_and_take(const std::vector<TextScanner>& pieces) {
    std::vector<std::optional<EdgeTextPiece<Dim>>> read(pieces.size());
    std::optional<Error> fault;
    parallel_in_order(
        pieces.size(), kPiecesAtOnce, [&](std::size_t k) { read[k] = read_edge_text_piece<Dim>(pieces[k], format_, context_); },
        [&](std::size_t k) {
          const EdgeTextPiece<Dim> piece = *std::exchange(read[k], std::nullopt);
          builder_.append(piece.builder);
          poses_.append(piece.poses);
          features_.append(piece.features);
          fault = piece.fault;
          return !fault;
        });
    return fault ? tl::unexpected(*fault) : Expected<void>();
  }

  Expected<void> check_once(DeclaredIds& declared, const char* what) const {
    declared.sort();
    const auto twice = declared.repetition();
    if (!twice) return {};
    return begin_.error(twice->place,
                        fmt::format("{} {} is declared a second time; two logs in one file are to be given as two files", what,
                                    key_text(twice->key)));
  }

  /// True if a FIX line names what no vertex declares.
  bool fixes_undeclared() const {
    return std::ranges::any_of(builder_.fixed_poses(),
                               [&](const PoseId& id) { return !poses_.contains(id.key) && !features_.contains(id.key); });
  }

  /// Bad input, with its place, if a FIX line names no pose, or a second one that nothing gives a value.
  Expected<void> check_fixed() const {
    std::set<std::uint64_t> without_value;
    for (const PoseId& id : builder_.fixed_poses()) {
      if (!poses_.contains(id.key)) without_value.insert(id.key);
    }
    const auto unknown = not_named_as_poses(begin_, format_, without_value);
    if (unknown.empty() && without_value.size() < 2) return {};
    std::optional<PoseId> first;
    for (const auto& [key, place] : fixed_names(begin_)) {
      if (!without_value.contains(key)) continue;
      const PoseId id{0, key};
      if (unknown.contains(key)) return begin_.error(place, fixed_without_pose(id));
      if (first.value_or(id) != id) return begin_.error(place, fixed_nowhere(id, *first));
      first = id;
    }
    return {};
  }

  void count_skipped(const LeftOut<Dim>& undeclared) {
    if (undeclared.factor_count() > 0) builder_.add_skipped(kEdgesToUndeclared, undeclared.factor_count());
    if (undeclared.fixed_poses > 0) builder_.add_skipped(kFixedUndeclared, undeclared.fixed_poses);
  }

  /// The error of the first line that names an id neither declared by a vertex nor foreign, found in a second pass over the
  /// file.
  Error first_undeclared() const {
    const Declared declared{[&](std::uint64_t key) { return poses_.contains(key); },
                            [&](std::uint64_t key) { return features_.contains(key); }};
    const bool with_edges = context_.options.undeclared != Undeclared::kForeign;
    const auto missing = mapjoin::first_undeclared(begin_, format_, declared, with_edges).value();
    return begin_
        .error(missing.place,
               fmt::format("the file declares vertices, but not {}; give the file that does as FURTHER, or --skip-undeclared",
                           missing.name))
        .value();
  }

  TextScanner begin_;
  const EdgeText<Dim>& format_;
  TextContext context_;
  std::size_t piece_bytes_;
  LogBuilder<Dim> builder_;
  DeclaredIds poses_;
  DeclaredIds features_;
};

}  // namespace

Expected<AnyLog> read_edge_text(TextScanner text, const EdgeText<2>& plane, const EdgeText<3>* space,
                                const ReadOptions& options, Extent extent) {
  for (TextScanner ahead = text; ahead.next_line();) {
    const std::string_view tag = ahead.word();
    if (plane.has_tag(tag)) return EdgeTextReader<2>(std::move(text), plane, options, extent).read();
    if (space && space->has_tag(tag)) return EdgeTextReader<3>(std::move(text), *space, options, extent).read();
    const bool is_passed_over = (plane.has_g2o_lines && (tag == kG2oFix || is_g2o_parameter(tag))) ||
                                (plane.is_passed_over && plane.is_passed_over(tag)) || options.skip_unknown;
    if (!is_passed_over) return ahead.error(fmt::format("unknown tag {}{}", in_quotes(tag), kSkipUnknown));
  }
  return bad_input(fmt::format("{}: the log has no poses", text.source()));
}

}  // namespace mapjoin
