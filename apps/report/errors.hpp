// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How far a map is from the truth: its absolute and relative trajectory errors, as evo defines them.

#include <apps/console.hpp>
#include <apps/report/json.hpp>
#include <apps/truth_file.hpp>
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

/// What spans are counted in.
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
  std::size_t poses = 0;                ///< Of the map, whether the truth has them or not.
  PoseErrorSummary absolute;            ///< Of those that it has.
  ErrorSummary features;                ///< Moved as the poses.
  std::vector<PoseErrorSummary> spans;  ///< By ErrorOptions::spans; within sessions.
  PoseErrorSummary relations;           ///< Between poses that edges of the truth tie.
};

/// The errors of a map; of no poses and features where the truth has none of its poses.
template <int Dim>
TruthErrors errors_of(const GlobalMap<Dim>& map, const TruthFile& truth, const ErrorOptions& options = {});

/// Null where there are none.
Json json_of(const std::optional<TruthErrors>& errors);
void add_errors(const TruthErrors& errors, Lines& lines);

}  // namespace apps
}  // namespace mapjoin
