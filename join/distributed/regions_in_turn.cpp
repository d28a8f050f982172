// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>
#include <mapjoin/distributed/regions_in_turn.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/parallel/isolated.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <numeric>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// The estimate of a region moved by a step.
template <int Dim>
Values<Dim> retracted(const Region<Dim>& region, Values<Dim> estimate, const Eigen::Ref<const Eigen::VectorXd>& step) {
  region.for_each_free_pose([&](PoseIndex place, Eigen::Index entry) {
    estimate.poses[place] = retract<Dim>(estimate.poses[place], step.template segment<kPoseDof<Dim>>(entry));
  });
  Eigen::Index entry = region.first_feature_entry();
  for (auto& feature : estimate.features) feature += step.template segment<Dim>(std::exchange(entry, entry + Dim));
  return estimate;
}

/// The first entries in a region's vectors of what its border has.
template <int Dim>
std::vector<Eigen::Index> entries_of(const Region<Dim>& region, const Border& border) {
  Table<PoseIndex, Eigen::Index> first(region.poses.size(), -1);
  region.for_each_free_pose([&](PoseIndex place, Eigen::Index entry) { first[place] = entry; });
  std::vector<Eigen::Index> entries;
  for (const PoseOrFeature& placed : border.places) {
    const auto* pose = std::get_if<PoseIndex>(&placed);
    const Eigen::Index begin = pose ? first[*pose] : region.first_feature_entry() + Dim * std::get<FeatureIndex>(placed).value;
    for (int i = 0; i < (pose ? kPoseDof<Dim> : Dim); ++i) entries.push_back(begin + i);
  }
  return entries;
}

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
    for (const Eigen::Index entry : entries_of(regions_[k], border)) shared_.entries.push_back(firsts_.back() + entry);
    shared_.unknowns.insert(shared_.unknowns.end(), border.unknowns.begin(), border.unknowns.end());
    firsts_.push_back(firsts_.back() + regions_[k].size());
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
  eliminated_[k].singular = region->factorise(damping_);
  if (eliminated_[k].singular) {
    eliminated_[k].singular = std::visit([&](auto place) { return name_of(regions_[k], place); }, *eliminated_[k].singular);
  }
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
  is_singular_ = comm_.any(is_singular || singular_here().has_value());
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
    const auto own = part(step, k);
    regions_[k].for_each_free_pose([&](PoseIndex, Eigen::Index entry) {
      size.metres = std::max(size.metres, own.template segment<Dim>(entry).norm());
      size.radians = std::max(size.radians, own.template segment<kRotationDof<Dim>>(entry + Dim).norm());
    });
    for (Eigen::Index entry = regions_[k].first_feature_entry(); entry < own.size(); entry += Dim) {
      size.metres = std::max(size.metres, own.template segment<Dim>(entry).norm());
    }
  }
  return {comm_.max(size.metres), comm_.max(size.radians)};
}

template <int Dim>
double RegionsInTurn<Dim>::chi2_of_candidate(std::size_t k) const {
  const Values<Dim>& values = candidates_[k];
  const FactorGraph<Dim> graph = factors_of(regions_[k]);
  const auto& poses = graph.pose_factors;
  const auto& features = graph.feature_factors;
  return parallel_sum(
             poses.size(), kObservationsPerPiece,
             [&](std::size_t i) { return cost(poses[i], values.pose(poses[i].base), values.poses[poses[i].target]); }) +
         parallel_sum(features.size(), kObservationsPerPiece, [&](std::size_t i) {
           return cost(features[i], values.pose(features[i].base), values.features[features[i].target]);
         });
}

template <int Dim>
double RegionsInTurn<Dim>::try_step(const Eigen::VectorXd& step) {
  double chi2 = 0.0;
  for (std::size_t k = 0; k < regions_.size(); ++k) {
    candidates_[k] = retracted<Dim>(regions_[k], estimates_[k], part(step, k));
    chi2 += chi2_of_candidate(k);
  }
  return comm_.sum(chi2);
}

template <int Dim>
std::optional<PoseOrFeature> RegionsInTurn<Dim>::singular_here() const {
  const auto first = std::ranges::find_if(eliminated_, [](const Eliminated& region) { return region.singular.has_value(); });
  return first == eliminated_.end() ? std::nullopt : first->singular;
}

template class RegionsInTurn<2>;
template class RegionsInTurn<3>;

}  // namespace mapjoin::distributed
