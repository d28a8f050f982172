// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/report/errors.hpp>
#include <mapjoin/model/log.hpp>
#include <numbers>

namespace mapjoin::apps {
namespace {

/// Pairs of poses of the map a span apart, within sessions; the path is that of the map, as evo takes it.
template <int Dim>
PosePairs pairs_of(const GlobalMap<Dim>& map, double span, const ErrorOptions& options) {
  return pairs_within_sessions(map.pose_ids, [&](const Session& session) {
    std::vector<Pose<Dim>> poses;
    for (PoseIndex p = session.begin; p < session.end; ++p) poses.push_back(map.poses[p]);
    return options.unit == SpanUnit::kMetres ? pairs_by_path(poses, span, options.pairs)
                                             : pairs_by_steps(poses.size(), static_cast<std::size_t>(span), options.pairs);
  });
}

std::string in_words(const ErrorSummary& errors, double scale, std::string_view unit) {
  return fmt::format("rms {:.4g}, mean {:.4g}, median {:.4g}, sd {:.4g}, min {:.4g}, max {:.4g} {}", scale * errors.rms,
                     scale * errors.mean, scale * errors.median, scale * errors.deviation, scale * errors.min,
                     scale * errors.max, unit);
}

void add_pose_errors(std::string_view name, const std::string& what, const PoseErrorSummary& errors, Lines& lines) {
  if (errors.translation.count == 0) return lines.add(name, what + ": none");
  lines.add(name, fmt::format("{}: {}", what, in_words(errors.translation, 1.0, "m")));
  if (errors.rotation.count > 0) lines.add("", in_words(errors.rotation, 180.0 / std::numbers::pi, "deg"));
}

std::string_view alignment_in_words(const TruthErrors& errors) {
  switch (errors.options.alignment) {
    case TrajectoryAlignment::kRigid:
      return errors.absolute.aligned_by == AlignedBy::kFeatures ? "aligned as a whole, with features" : "aligned as a whole";
    case TrajectoryAlignment::kOrigin:
      return "aligned at the first pose";
    case TrajectoryAlignment::kNone:
      break;
  }
  return "not aligned";
}

}  // namespace

template <int Dim>
TruthErrors errors_of(const GlobalMap<Dim>& map, const TruthFile& file, const ErrorOptions& options) {
  const Truth<Dim> truth = file.of(map);
  TruthErrors errors{options, map.poses.size(), absolute_errors(map, truth, options.alignment), {}, {}};
  errors.known_features = static_cast<std::size_t>(std::ranges::count_if(truth.features, [](const auto& f) { return !!f; }));
  if (errors.absolute.poses.translation.count == 0) return errors;
  for (const double span : options.spans) errors.spans.push_back(relative_errors(map, truth, pairs_of(map, span, options)));
  PosePairs relations;
  for (const auto& [base, target] : file.relations(map.pose_ids)) relations.emplace_back(base.position(), target.position());
  errors.relations = relative_errors(map, truth, relations);
  return errors;
}

Json json_of(const std::optional<TruthErrors>& errors) {
  if (!errors) return nullptr;
  return {{"alignment", errors->options.alignment},
          {"poses", errors->poses},
          {"ate", errors->absolute.poses},
          {"features", errors->absolute.features},
          {"unit", errors->options.unit},
          {"pairs", errors->options.pairs},
          {"rpe", over_spans(errors->options.spans, errors->spans)},
          {"relations", errors->relations}};
}

void add_errors(const TruthErrors& errors, Lines& lines) {
  const auto& [poses, features, aligned_by] = errors.absolute;
  if (poses.translation.count == 0) return;
  add_pose_errors("ATE", fmt::format("{} of {} poses, {}", poses.translation.count, errors.poses, alignment_in_words(errors)),
                  poses, lines);
  if (aligned_by == AlignedBy::kTooLittle) {
    lines.add("", "rotations and features unknown: positions that leave a rotation free do not align them");
  }
  if (features.count > 0) lines.add("features", fmt::format("{}: {}", features.count, in_words(features, 1.0, "m")));
  for (std::size_t k = 0; k < errors.spans.size(); ++k) {
    const double span = errors.options.spans[k];
    const std::string unit = errors.options.unit == SpanUnit::kMetres ? "m" : span == 1.0 ? "step" : "steps";
    add_pose_errors("RPE", fmt::format("over {:g} {}", span, unit), errors.spans[k], lines);
  }
  if (errors.relations.translation.count > 0) {
    add_pose_errors("relations",
                    "between " + plural(errors.relations.translation.count, "pair") + " that edges of the truth tie",
                    errors.relations, lines);
  }
}

template TruthErrors errors_of(const GlobalMap<2>&, const TruthFile&, const ErrorOptions&);
template TruthErrors errors_of(const GlobalMap<3>&, const TruthFile&, const ErrorOptions&);

}  // namespace mapjoin::apps
