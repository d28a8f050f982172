// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <atomic>
#include <mapjoin/join/polish_problem.hpp>
#include <mapjoin/localmap/recover.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <utility>

namespace mapjoin {

template <int Dim>
PolishProblem<Dim>::PolishProblem(JointSystem<Dim>& system, const std::vector<Segment<Dim>>& segments,
                                  const std::vector<bool>& is_private, const State<Dim>& state)
    : system_(system), size_(system.equations().size()) {
  std::vector<Eigen::Index> offsets;
  for (const auto& segment : segments) {
    offsets.push_back(size_);
    size_ += LiveSegment<Dim>::own_size(segment, is_private);
  }
  segments_.resize(segments.size());
  parallel_for(segments.size(), [&](std::size_t k) {
    segments_[k] = std::make_unique<LiveSegment<Dim>>(segments[k], is_private, system.equations(), system.map_variables(k),
                                                      offsets[k], values_of(segments[k], state));
  });
}

template <int Dim>
double PolishProblem<Dim>::linearise() {
  is_reduced_ = false;
  const double chi2 = system_.linearise_observations();
  const double segments_chi2 = parallel_sum(segments_.size(), 1, [&](std::size_t k) { return segments_[k]->linearise(); });
  gradient_.setZero(size_);
  gradient_.head(system_.equations().size()) = system_.equations().gradient();
  for (const auto& segment : segments_) segment->add_gradient(gradient_);
  return chi2 + segments_chi2;
}

template <int Dim>
DiagonalMetric PolishProblem<Dim>::metric() const {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(size_);
  diagonal.head(system_.equations().size()) = system_.equations().diagonal();
  for (const auto& segment : segments_) segment->add_diagonal(diagonal);
  return DiagonalMetric(std::move(diagonal));
}

template <int Dim>
void PolishProblem<Dim>::restore_observations() {
  if (is_reduced_) system_.linearise_observations();
  is_reduced_ = false;
}

template <int Dim>
double PolishProblem<Dim>::curvature(const Eigen::VectorXd& v) {
  restore_observations();
  return system_.equations().curvature(v.head(system_.equations().size())) +
         parallel_sum(segments_.size(), 1, [&](std::size_t k) { return segments_[k]->curvature(v); });
}

template <int Dim>
bool PolishProblem<Dim>::eliminate_segments(double damping) {
  std::atomic<bool> is_regular = true;
  parallel_for(segments_.size(), [&](std::size_t k) {
    if (!segments_[k]->eliminate(damping)) is_regular = false;
  });
  return is_regular;
}

template <int Dim>
std::optional<Index> PolishProblem<Dim>::factorise(double damping) {
  // The diagonal to damp is that of the whole system, before anything is eliminated from it.
  restore_observations();
  is_reduced_ = true;
  if (damping > 0.0) system_.equations().damp(damping);
  if (!eliminate_segments(damping)) return 0;
  system_.add_maps([&](std::size_t k, NormalEquations::Sink sink) { segments_[k]->add_reduced(sink); });
  return system_.equations().factorise(0.0);
}

template <int Dim>
Eigen::VectorXd PolishProblem<Dim>::solve() {
  if (!is_reduced_) {
    parallel_for(segments_.size(), [&](std::size_t k) { segments_[k]->eliminate_gradient(); });
    system_.add_maps([&](std::size_t k, NormalEquations::Sink sink) { segments_[k]->add_reduced_gradient(sink); });
    is_reduced_ = true;
  }
  const NormalEquations& equations = system_.equations();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(size_);
  step.head(equations.size()) = equations.solve(equations.gradient());
  parallel_for(segments_.size(), [&](std::size_t k) { segments_[k]->back_substitute(step); });
  return step;
}

template <int Dim>
StepSize PolishProblem<Dim>::step_size(const Eigen::VectorXd& step) const {
  StepSize size = system_.step_size(step);
  for (const auto& segment : segments_) segment->add_step_size(step, size);
  return size;
}

template <int Dim>
double PolishProblem<Dim>::try_step(const Eigen::VectorXd& step) {
  candidate_ = system_.retracted(step);
  return system_.observations_chi2(candidate_) +
         parallel_sum(segments_.size(), 1, [&](std::size_t k) { return segments_[k]->try_step(step); });
}

template <int Dim>
void PolishProblem<Dim>::accept() {
  std::swap(system_.estimate(), candidate_);
  for (auto& segment : segments_) segment->accept();
}

template <int Dim>
void PolishProblem<Dim>::write_interiors(State<Dim>& state) const {
  for (const auto& segment : segments_) segment->write_own(state);
}

template class PolishProblem<2>;
template class PolishProblem<3>;

}  // namespace mapjoin
