// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/formats/edge_text_piece.hpp>
#include <mapjoin/io/formats/skipped_lines.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
class PieceReader {
 public:
  PieceReader(TextScanner text, const EdgeText<Dim>& format, const TextContext& context)
      : text_(std::move(text)),
        format_(format),
        context_(context),
        check_(context.options.repair_information),
        read_{LogBuilder<Dim>("", {}, Numbers::kChecked), {}, {}, {}} {}

  EdgeTextPiece<Dim> read() && {
    while (!read_.fault && text_.next_line()) {
      if (const auto line = read_line(text_.word()); !line) read_.fault = line.error();
    }
    read_.builder.add_repairs(check_.repairs());
    return std::move(read_);
  }

 private:
  Expected<void> read_line(std::string_view tag) {
    if (tag == format_.edge_tag) return read_edge();
    if (tag == format_.observation_tag) return read_observation();
    if (tag == format_.pose_tag) return read_pose();
    if (tag == format_.feature_tag) return read_feature();
    if (format_.has_g2o_lines && tag == kG2oFix) return read_fix();
    if (format_.has_g2o_lines && is_g2o_parameter(tag)) return {};
    if (const PriorTag* prior = format_.prior(tag)) return read_prior(*prior);
    if (context_.options.skip_unknown || (format_.is_passed_over && format_.is_passed_over(tag))) {
      read_.builder.add_skipped(lines_of(tag));
      return {};
    }
    const bool is_of_other = format_.is_of_other_dimension && format_.is_of_other_dimension(tag);
    const std::string what =
        is_of_other ? fmt::format("{} in a file of dimension {}", tag, Dim) : "unknown tag " + in_quotes(tag);
    return text_.error(what + kSkipUnknown);
  }

  Expected<void> read_pose() {
    const Place place = text_.place();
    const PoseId id{0, text_.key()};
    read_.builder.add_pose(id, format_.read_pose(text_));
    read_.poses.add(id.key, place);
    return text_.finish_line();
  }

  Expected<void> read_feature() {
    const Place place = text_.place();
    const FeatureId id{text_.key()};
    read_.builder.add_feature(id, text_.vector<Dim>());
    read_.features.add(id.key, place);
    return text_.finish_line();
  }

  Expected<void> read_fix() {
    do {
      const PoseId id{0, text_.key()};
      if (context_.is_whole) read_.builder.fix(id);
    } while (!text_.at_end_of_line());
    return text_.finish_line();
  }

  Expected<void> read_edge() {
    const Place place = text_.place();
    const PoseId base{0, text_.key()};
    const PoseId target{0, text_.key()};
    auto [measured, W] = format_.read_edge(text_, context_);
    if (format_.weights == Weights::kCovariance) W = inverse_of(W, check_, text_);
    if (auto line = text_.finish_line(); !line) return line;
    if (base == target) return read_self_edge(place, base);
    if (const auto fault = check_.fault(W)) return unfit(place, name_of(base, target), *fault);
    read_.builder.add_pose_edge(base, target, measured, W);
    return {};
  }

  Expected<void> read_self_edge(const Place& place, PoseId pose) {
    if (!context_.options.skip_self_edges) {
      return text_.error(
          place, fmt::format("an edge leads from {} to itself; --skip-self-edges leaves such edges out", to_string(pose)));
    }
    read_.builder.add_skipped("self-edges");
    return {};
  }

  Expected<void> read_prior(const PriorTag& tag) {
    return tag.kind == PriorTag::Kind::kFeature ? read_feature_prior() : read_pose_prior(tag);
  }

  Expected<void> read_feature_prior() {
    const Place place = text_.place();
    const FeatureId id{text_.key()};
    auto [measured, W] = read_plain_point<Dim>(text_, context_);
    if (auto line = text_.finish_line(); !line) return line;
    if (const auto fault = check_.fault(W)) return unfit(place, "the prior of " + to_string(id), *fault);
    read_.builder.add_feature_prior(id, measured, W);
    return {};
  }

  Expected<void> read_pose_prior(const PriorTag& tag) {
    const Place place = text_.place();
    const PoseId id{0, text_.key()};
    auto [measured, W] = format_.read_pose_prior(tag, text_, context_);
    if (auto line = text_.finish_line(); !line) return line;
    if (const auto fault = check_.fault(W)) return unfit(place, "the prior of " + to_string(id), *fault);
    read_.builder.add_pose_prior(id, measured, W);
    return {};
  }

  Expected<void> read_observation() {
    const Place place = text_.place();
    const PoseId pose{0, text_.key()};
    const auto feature = format_.may_be_unassociated ? read_feature_or_none(text_) : FeatureId{text_.key()};
    auto [measured, W] = format_.read_point(text_, context_);
    if (format_.weights == Weights::kCovariance && feature) W = inverse_of(W, check_, text_);
    if (auto line = text_.finish_line(); !line) return line;
    if (!feature) {
      read_.builder.add_unassociated();
      return {};
    }
    if (const auto fault = check_.fault(W)) return unfit(place, name_of(pose, *feature), *fault);
    if (!measured.allFinite()) return text_.error(place, fmt::format("{} is too far away", to_string(*feature)));
    read_.builder.add_observation(pose, *feature, measured, W);
    return {};
  }

  tl::unexpected<Error> unfit(const Place& place, const std::string& what, const std::string& fault) const {
    return text_.error(place, fmt::format("the information matrix of {} {}", what, fault));
  }

  TextScanner text_;
  const EdgeText<Dim>& format_;
  const TextContext& context_;
  InformationCheck check_;
  EdgeTextPiece<Dim> read_;
};

}  // namespace

bool is_unweighed(TextScanner& text, const TextContext& context) {
  if (!text.at_end_of_line()) return false;
  if (!context.options.identity_where_missing) {
    text.word();  // Moves to the end of the line, which the message is about.
    text.reject("the line ends where its weights are expected; --identity-where-missing takes the identity for them");
    return false;
  }
  ++context.unweighed;
  return true;
}

std::optional<FeatureId> read_feature_or_none(TextScanner& text) {
  const std::int64_t key = text.integer();
  if (key == -1) return std::nullopt;
  if (key < 0) text.reject(fmt::format("a feature has the id {}", key));
  return FeatureId{static_cast<std::uint64_t>(key)};
}

template <int Size>
Matrix<Size> inverse_of(Matrix<Size> covariance, InformationCheck& check, TextScanner& text) {
  if (const auto fault = check.invert<Size>(covariance)) text.reject("the covariance that ends here " + *fault);
  return covariance;
}

template <int Dim>
EdgeTextPiece<Dim> read_edge_text_piece(TextScanner piece, const EdgeText<Dim>& format, const TextContext& context) {
  return PieceReader<Dim>(std::move(piece), format, context).read();
}

template Matrix<2> inverse_of(Matrix<2>, InformationCheck&, TextScanner&);
template Matrix<3> inverse_of(Matrix<3>, InformationCheck&, TextScanner&);
template Matrix<6> inverse_of(Matrix<6>, InformationCheck&, TextScanner&);
template EdgeTextPiece<2> read_edge_text_piece(TextScanner, const EdgeText<2>&, const TextContext&);
template EdgeTextPiece<3> read_edge_text_piece(TextScanner, const EdgeText<3>&, const TextContext&);

}  // namespace mapjoin
