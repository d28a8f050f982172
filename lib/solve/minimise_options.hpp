// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Options and results of the nonlinear loop.

#include <algorithm>
#include <cstdint>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin {

enum class Method : std::uint8_t {
  kGaussNewton,  ///< Every step is taken, better or not: for experiments.
  kDogleg,       ///< Powell's dogleg: one factorisation per linearisation.
  kLevenbergMarquardt,
};

constexpr auto enum_names(Method) {
  return std::to_array<EnumName<Method>>(
      {{Method::kDogleg, "dogleg"}, {Method::kLevenbergMarquardt, "lm"}, {Method::kGaussNewton, "gn"}});
}

/// The factorisation of sparse normal equations.
enum class Engine : std::uint8_t {
  kFronts,   ///< mapjoin's multifrontal factorisation, on all threads.
  kCholmod,  ///< SuiteSparse's CHOLMOD on one thread: an independent factorisation to compare with.
};

constexpr auto enum_names(Engine) {
  return std::to_array<EnumName<Engine>>({{Engine::kFronts, "fronts"}, {Engine::kCholmod, "cholmod"}});
}

/// The relative decrease of chi2 below which an estimate has converged: that promised by the whole, undamped step. Steps that
/// are asked to go on beyond may do so as far as rounding lets chi2 tell.
constexpr double kConvergedShare = 1e-9;

struct MinimiseOptions {
  Method method = Method::kDogleg;
  int max_iterations = 200;
  double relative_chi2 = kConvergedShare;  ///< Share of chi2: steps end when the whole step promises less.
  double step_metres = 1e-9;               ///< Steps end at moves (m) up to this and turns up to step_radians.
  double step_radians = 1e-9;              ///< Steps end at turns (rad) up to this and moves up to step_metres.
  bool damp_singular = false;              ///< True: damp a singular system instead of stopping.
  Engine engine = Engine::kFronts;         ///< Factorisation of sparse systems.

  /// True if an estimate of this chi2 has converged, for every solve by every method: the whole step from it, Gauss-Newton's or
  /// Newton's, promises at most the larger of relative_chi2 and kConvergedShare, as a share of chi2.
  bool is_converged(double promise, double chi2) const { return promise <= std::max(relative_chi2, kConvergedShare) * chi2; }
  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const {
    std::vector<std::string> violations;
    if (max_iterations < 1) violations.emplace_back("the number of iterations must be at least 1");
    if (!(relative_chi2 >= 0.0)) violations.emplace_back("the relative decrease of chi2 to stop at must not be negative");
    if (!(step_metres >= 0.0)) violations.emplace_back("the step in metres to stop at must not be negative");
    if (!(step_radians >= 0.0)) violations.emplace_back("the step in radians to stop at must not be negative");
    return violations;
  }
};

enum class MinimiseStatus : std::uint8_t {
  kConverged,      ///< The whole step promises next to nothing (MinimiseOptions::is_converged), or is tiny.
  kMaxIterations,  ///< The estimate is the best found so far.
  kNoProgress,     ///< No step lowers chi2 though the whole one promises it, or chi2 is not finite.
  kSingular,       ///< `singular` cannot be determined from the observations; the estimate is the last good one.
  kInterrupted,    ///< The stop token was set; the estimate is the best found so far.
};

constexpr auto enum_names(MinimiseStatus) {
  return std::to_array<EnumName<MinimiseStatus>>({{MinimiseStatus::kConverged, "converged"},
                                                  {MinimiseStatus::kMaxIterations, "max_iterations"},
                                                  {MinimiseStatus::kNoProgress, "no_progress"},
                                                  {MinimiseStatus::kSingular, "singular"},
                                                  {MinimiseStatus::kInterrupted, "interrupted"}});
}

struct MinimiseResult {
  MinimiseStatus status = MinimiseStatus::kConverged;
  int iterations = 0;
  int factorisations = 0;  ///< Fewer than iterations if one factor served several steps.
  int short_steps = 0;     ///< Steps tried that gained less than 0.4 of what the model promised.
  double start_chi2 = 0.0;
  double chi2 = 0.0;
  std::vector<double> course;        ///< chi2 after each iteration.
  std::optional<Variable> singular;  ///< A variable that cannot be determined.

  /// Counts one iteration more, to an estimate of this chi2.
  void moved_to(double new_chi2) {
    chi2 = new_chi2;
    ++iterations;
    course.push_back(new_chi2);
  }
  /// Appends the result of going on from here.
  void append(const MinimiseResult& further) {
    iterations += further.iterations;
    factorisations += further.factorisations;
    short_steps += further.short_steps;
    course.insert(course.end(), further.course.begin(), further.course.end());
    status = further.status;
    chi2 = further.chi2;
    singular = further.singular;
  }
  MinimiseResult& ended(MinimiseStatus with) {
    status = with;
    return *this;
  }
};

/// The largest move of a position (m) and the largest turn of a pose (rad) in a step.
struct StepSize {
  double metres = 0.0;
  double radians = 0.0;
};

}  // namespace mapjoin
