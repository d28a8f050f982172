// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>
#include <mapjoin/distributed/regions/regions_in_turn.hpp>
#include <mapjoin/join/free_to_move.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/parallel/pieces.hpp>
#include <numeric>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// Calls f(region) for each, as many at a time as there are threads.
template <typename F>
void for_each_region(std::size_t count, F&& f) {
  parallel_for(count, [&](std::size_t k) { isolated([&] { f(k); }); });
}

}  // namespace

template <int Dim>
RegionsInTurn<Dim>::RegionsInTurn(const Communicator& comm, const Regions<Dim>& regions, const MumpsOptions& options)
    : comm_(comm),
      regions_(regions.own),
      interface_(interface_of(comm, regions)),
      candidates_(regions_.size()),
      firsts_{0},
      shared_{interface_.size, {}, {}},
      orders_(regions_.size()),
      eliminated_(regions_.size()),
      solver_(comm, interface_.outer, interface_.outer_faces, options) {
  for (std::size_t k = 0; k < regions_.size(); ++k) {
    estimates_.push_back(regions_[k].start);
    const Border& border = interface_.borders[k];
    for (const Eigen::Index entry : entries_of(border, regions_[k])) shared_.entries.push_back(firsts_.back() + entry);
    append(shared_.unknowns, border.unknowns);
    firsts_.push_back(firsts_.back() + variables_of(regions_[k]).size());
    if (border.faces.empty()) continue;
    fronts_.push_back({border.faces, {nullptr, 0, 0, Eigen::OuterStride<>(0)}, [this, k](DenseBlock S) {
                         isolated([&] { eliminate(k, S); });
                       }});
  }
  std::vector<std::int64_t> bytes(regions_.size());
  for_each_region(regions_.size(), [&](std::size_t k) {
    bytes[k] = RegionElimination<Dim>(regions_[k], estimates_[k], interface_.borders[k], orders_[k]).bytes();
  });
  std::ranges::sort(bytes, std::greater<>());
  bytes.resize(std::min(bytes.size(), most_at_once()));
  largest_bytes_ = std::accumulate(bytes.begin(), bytes.end(), std::int64_t{0});
  gradient_.setZero(firsts_.back());
  diagonal_.setZero(firsts_.back());
  solver_.analyse(interface_.faces, fronts_);
}

template <int Dim>
std::unique_ptr<RegionElimination<Dim>> RegionsInTurn<Dim>::linearised(std::size_t k) {
  auto region = std::make_unique<RegionElimination<Dim>>(regions_[k], estimates_[k], interface_.borders[k], orders_[k]);
  eliminated_[k].chi2 = region->linearise(is_curved_);
  return region;
}

template <int Dim>
void RegionsInTurn<Dim>::eliminate(std::size_t k, DenseBlock schur_complement) {
  const auto region = linearised(k);
  part(gradient_, k) = region->equations().gradient();
  if (!is_curved_) part(diagonal_, k) = region->equations().diagonal();  // D stays that of Gauss-Newton
  eliminated_[k].is_singular = !region->factorise(damping_);
  eliminated_[k].forward = region->forward(part(gradient_, k));
  schur_complement.template triangularView<Eigen::Lower>() = region->schur_complement();
}

template <int Dim>
void RegionsInTurn<Dim>::eliminate_all(double damping) {
  damping_ = damping;
  is_solved_ = false;
  for (std::size_t k = 0; k < regions_.size(); ++k) {
    if (interface_.borders[k].faces.empty()) eliminate(k, {nullptr, 0, 0, Eigen::OuterStride<>(0)});
  }
  const bool is_singular = !solver_.factorise(interface_.faces, fronts_).empty();
  is_singular_ = comm_.any(is_singular || std::ranges::any_of(eliminated_, &Eliminated::is_singular));
  is_factorised_ = true;
}

template <int Dim>
double RegionsInTurn<Dim>::linearise() {
  is_curved_ = false;
  eliminate_all(0.0);
  double chi2 = 0.0;
  for (const Eliminated& region : eliminated_) chi2 += region.chi2;
  return comm_.sum(chi2);
}

template <int Dim>
void RegionsInTurn<Dim>::add_curvature() {
  is_curved_ = true;
  is_factorised_ = false;
}

template <int Dim>
std::optional<Variable> RegionsInTurn<Dim>::factorise(double damping) {
  if (!is_factorised_ || damping != damping_) eliminate_all(damping);
  return is_singular_ ? std::optional<Variable>(0) : std::nullopt;
}

template <int Dim>
double RegionsInTurn<Dim>::curvature(const Eigen::VectorXd& v) {
  std::vector<double> of(regions_.size());
  for_each_region(regions_.size(), [&](std::size_t k) { of[k] = linearised(k)->equations().curvature(part(v, k)); });
  return comm_.sum(std::accumulate(of.begin(), of.end(), 0.0));
}

template <int Dim>
const Eigen::VectorXd& RegionsInTurn<Dim>::solve() {
  if (is_solved_) return solution_;
  Eigen::VectorXd shared = Eigen::VectorXd::Zero(interface_.faces.size());
  for (std::size_t k = 0; k < regions_.size(); ++k) {
    const Eigen::VectorXd& y = eliminated_[k].forward;
    for_each_face(k, [&](Eigen::Index face, Eigen::Index entry, Eigen::Index size) {
      shared.segment(face, size) += y.segment(entry, size);
    });
  }
  shared = solver_.solve(shared);
  solution_.resize(firsts_.back());
  for_each_region(regions_.size(), [&](std::size_t k) {
    Eigen::VectorXd y = eliminated_[k].forward;
    for_each_face(k, [&](Eigen::Index face, Eigen::Index entry, Eigen::Index size) {
      y.segment(entry, size) = shared.segment(face, size);
    });
    const auto region = linearised(k);
    region->factorise(damping_);
    part(solution_, k) = region->backward(std::move(y));
  });
  is_solved_ = true;
  return solution_;
}

template <int Dim>
StepSize RegionsInTurn<Dim>::step_size(const Eigen::VectorXd& step) const {
  StepSize size;
  for (std::size_t k = 0; k < regions_.size(); ++k) {
    const StepSize own = variables_of(regions_[k]).step_size(part(step, k));
    size = {std::max(size.metres, own.metres), std::max(size.radians, own.radians)};
  }
  return {comm_.max(size.metres), comm_.max(size.radians)};
}

template <int Dim>
double RegionsInTurn<Dim>::try_step(const Eigen::VectorXd& step) {
  double chi2 = 0.0;
  for (std::size_t k = 0; k < regions_.size(); ++k) {
    candidates_[k] = variables_of(regions_[k]).retracted(estimates_[k], part(step, k));
    chi2 += graph_chi2(factors_of(regions_[k]), candidates_[k]);
  }
  return comm_.sum(chi2);
}

template <int Dim>
std::string RegionsInTurn<Dim>::free_here(const LogPart<Dim>& whole) {
  const auto first = std::ranges::find_if(eliminated_, &Eliminated::is_singular);
  if (first == eliminated_.end()) return "";
  const auto k = static_cast<std::size_t>(first - eliminated_.begin());
  const Region<Dim>& region = regions_[k];
  return linearised(k)->free_to_move(names_at(region.poses, whole.poses), names_at(region.features, whole.features));
}

template class RegionsInTurn<2>;
template class RegionsInTurn<3>;

}  // namespace mapjoin::distributed
