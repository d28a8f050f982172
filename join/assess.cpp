// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <mapjoin/join/assess.hpp>
#include <mapjoin/measure/effort.hpp>
#include <utility>

namespace mapjoin {
namespace {

bool wants_covariances(const RunOptions& options) {
  return options.covariances || options.marginals;
}

/// Computes the verdict, marginals and covariances into `result`; bad input if the covariances are not finite.
template <int Dim>
Expected<void> assess(Restored<Dim>& restored, std::span<const PoseFactor<Dim>> odometry, const RunOptions& options,
                      const std::stop_token& stop, RunResult<Dim>& result) {
  const bool is_tested = options.verdict && result.converged();
  const bool is_polished = result.polish || result.local_maps == 0;  // without local maps the join is of the whole log
  auto covariances =
      MapCovariances<Dim>::make(restored, is_polished ? Estimate::kPolished : Estimate::kJoined, options.most_memory);
  if (!covariances) return tl::unexpected(covariances.error());
  if (is_tested || options.marginals) {
    const auto on_pattern = covariances->on_pattern(options.progress_of(Stage::kCovariances), stop);
    if (!on_pattern && (options.marginals || on_pattern.error().kind != ErrorKind::kTooLarge)) {
      return tl::unexpected(on_pattern.error());
    }
    if (!on_pattern) result.no_verdict = on_pattern.error();
    if (on_pattern && options.marginals) result.marginals = covariances->marginals(*on_pattern);
    if (on_pattern && is_tested) {
      const Stopwatch watch(result.seconds.verdict);
      result.fit =
          goodness_of_fit(restored, covariances->equations(), *on_pattern, result.dof, odometry, options.most_misfits, stop);
      if (stop.stop_requested()) return interrupted("testing the fit");
    }
  }
  if (wants_covariances(options)) result.covariances = std::make_shared<const MapCovariances<Dim>>(*std::move(covariances));
  return {};
}

}  // namespace

template <int Dim>
Expected<void> check_finite(const RunResult<Dim>& result, const std::string& source) {
  if (is_valid(result.map) && std::isfinite(result.chi2)) return {};
  return bad_input_of(source,
                      "its numbers are too large: the map is not finite, or its chi2; what is unknown is left out, and what is "
                      "exact weighs 1e4 times the others, say");
}

bool wants_assessment(const RunOptions& options) {
  return options.verdict || wants_covariances(options);
}

template <int Dim>
Expected<RunResult<Dim>> assessed(Found<Dim> found, std::span<const PoseFactor<Dim>> odometry, const RunOptions& options,
                                  const std::stop_token& stop) {
  RunResult<Dim>& result = found.result;
  if (!result.converged()) result.fit.verdict = Verdict::kUnconverged;
  if (!wants_covariances(options) && !(options.verdict && result.converged())) return std::move(result);
  if (options.progress) options.progress(Stage::kCovariances, 0, 1);
  const auto done = [&] {
    const Stopwatch watch(result.seconds.covariances);
    return assess(*found.restored, odometry, options, stop, result);
  }();
  result.seconds.covariances -= result.seconds.verdict;  // counted apart
  if (done) return std::move(result);
  if (done.error().kind != ErrorKind::kBadInput) return tl::unexpected(done.error());
  if (wants_covariances(options)) result.no_covariances = done.error();
  if (options.verdict) result.no_verdict = done.error();
  return std::move(result);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                              \
  template Expected<void> check_finite(const RunResult<Dim>&, const std::string&);                            \
  template Expected<RunResult<Dim>> assessed(Found<Dim>, std::span<const PoseFactor<Dim>>, const RunOptions&, \
                                             const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
