// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The errors of a map against the truth: absolute and relative trajectory errors, as evo defines them.

#include <apps/console.hpp>
#include <apps/report/json.hpp>
#include <apps/truth_file.hpp>
#include <mapjoin/join/study/truth_errors.hpp>
#include <mapjoin/measure/trajectory_error.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

inline void to_json(nlohmann::ordered_json& json, const ErrorSummary& errors) {
  json = {{"count", errors.count}};
  json.update(apps::if_known(errors.count > 0, {{"rms", errors.rms},
                                                {"mean", errors.mean},
                                                {"median", errors.median},
                                                {"deviation", errors.deviation},
                                                {"min", errors.min},
                                                {"max", errors.max}}));
}
inline void to_json(nlohmann::ordered_json& json, const PoseErrorSummary& errors) {
  json = {{"translation", errors.translation}, {"rotation", errors.rotation}};
}

namespace apps {

/// The unit of spans.
enum class SpanUnit : std::uint8_t { kSteps, kMetres };
constexpr auto enum_names(SpanUnit) {
  return std::to_array<EnumName<SpanUnit>>({{SpanUnit::kSteps, "steps"}, {SpanUnit::kMetres, "metres"}});
}

struct ErrorOptions {
  TrajectoryAlignment alignment = TrajectoryAlignment::kRigid;
  std::vector<double> spans = {1.0, 10.0, 100.0};
  SpanUnit unit = SpanUnit::kSteps;
  SpanPairs pairs = SpanPairs::kAll;
};

struct TruthErrors {
  ErrorOptions options;
  std::size_t poses = 0;                ///< Number of poses of the map, known to the truth or not.
  AbsoluteErrors absolute;              ///< Errors of those known, and of features.
  std::vector<PoseErrorSummary> spans;  ///< Relative errors by ErrorOptions::spans; within sessions.
  PoseErrorSummary relations;           ///< Relative errors between poses that edges of the truth tie.
  std::size_t known_features = 0;       ///< Number of features of the map that the truth knows.
};

/// The errors of a map; all of them empty if the truth has none of its poses.
template <int Dim>
TruthErrors errors_of(const GlobalMap<Dim>& map, const TruthFile& truth, const ErrorOptions& options = {});

/// Relative errors as JSON, each with its span.
template <typename Span>
Json over_spans(const std::vector<Span>& spans, const std::vector<PoseErrorSummary>& errors) {
  Json all = Json::array();
  for (std::size_t k = 0; k < errors.size(); ++k) {
    all.push_back({{"span", spans[k]}});
    all.back().update(Json(errors[k]));
  }
  return all;
}
/// The errors as JSON; null if there are none.
Json json_of(const std::optional<TruthErrors>& errors);
void add_errors(const TruthErrors& errors, Lines& lines);

}  // namespace apps
}  // namespace mapjoin
