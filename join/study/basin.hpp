// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The experiment of the paper's Table I: from which initial values does least squares reach the optimum, and how often?

#include <array>
#include <functional>
#include <limits>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/study/formulation.hpp>
#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/enum_names.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin {

/// The method that solves a cell of the experiment, all observations or maps at once.
enum class BasinMethod : std::uint8_t {
  kGaussNewton,  ///< Gauss-Newton: every step is taken, better or not.
  kDefault,      ///< Dogleg; in the relative state by continuation.
};

constexpr auto enum_names(BasinMethod) {
  return std::to_array<EnumName<BasinMethod>>({{BasinMethod::kGaussNewton, "gn"}, {BasinMethod::kDefault, "default"}});
}

inline constexpr std::array kBasinStarts = {Start::kComposed, Start::kZero, Start::kRandom};

struct BasinOptions {
  std::vector<SplitOptions> splits = {SplitOptions{}};  ///< Splits of a log into the local maps that are joined.
  int seeds = 20;                                       ///< Random starts per cell: seeds 1, 2, …
  int max_iterations = 200;                             ///< Limit of each solve; by continuation, of the last one.
  /// Called with the solves done and to do; from one thread at a time.
  std::function<void(std::size_t, std::size_t)> progress;

  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

/// One solve.
struct BasinRun {
  double chi2 = std::numeric_limits<double>::infinity();  ///< chi2 of the whole log, polished, or of the maps of a set.
  int iterations = 0;                                   ///< Iterations of the joint solve, by continuation with the path to it.
  MinimiseStatus status = MinimiseStatus::kNoProgress;  ///< Status of the joint solve.
  std::optional<std::string> failure;                   ///< Reason why there is no chi2, in words.
  bool is_at_optimum = false;                           ///< True if chi2 is the best known one, to 1e-6 of it.
};

struct BasinCell {
  Covariance covariance = Covariance::kOriginal;
  Formulation formulation;
  std::optional<SplitOptions> split;  ///< Split for joining; nullopt for full SLAM, and for maps that were cut before.
  std::size_t maps = 0;               ///< Number of local maps that are joined; 0 for full SLAM.
  BasinMethod method = BasinMethod::kGaussNewton;
  Start start = Start::kComposed;
  std::vector<BasinRun> runs;  ///< One run, or one per seed of the random start.

  static std::uint64_t seed_of(std::size_t run) { return run + 1; }  ///< Seed of the random start of a run.
  std::size_t hits() const;                                          ///< Number of runs that end at the optimum.
};

struct Basin {
  std::vector<Covariance> covariances;
  std::vector<double> best_chi2;  ///< Least chi2 per covariance, of all cells and of a join by the default schedule.
  std::vector<BasinCell> cells;   ///< Cells by covariance, problem, split, state, method and start, in this order.
};

/// The experiment with all four formulations of a log, with its covariances and, unless these are identities, with identity
/// covariances. Cells are solved in parallel, with the same result for any number of threads. Bad input as run(), or if no
/// solve gives a map; kInterrupted on `stop`. Throws std::invalid_argument with the first violation of `options`.
template <int Dim>
Expected<Basin> basin(const Log<Dim>& log, const BasinOptions& options, const std::stop_token& stop = {});

/// The experiment with a log that is split already; `options.splits` is not used. Otherwise as with a log alone.
template <int Dim>
Expected<Basin> basin(const Log<Dim>& log, const Split& split, const BasinOptions& options, const std::stop_token& stop = {});

/// The experiment with the two joining formulations of local maps; identity covariances replace the maps' information. Errors
/// as with a log.
template <int Dim>
Expected<Basin> basin(const SubmapSet<Dim>& set, const BasinOptions& options, const std::stop_token& stop = {});

}  // namespace mapjoin
