// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <mapjoin/join/join_problem.hpp>
#include <mapjoin/join/map_covariances.hpp>
#include <mapjoin/join/polish_problem.hpp>
#include <mapjoin/localmap/recover.hpp>
#include <mapjoin/solve/memory.hpp>
#include <optional>
#include <utility>

namespace mapjoin {

template <int Dim>
MapCovariances<Dim>::MapCovariances(Network<Dim> network, Join<Dim> join, std::vector<Segment<Dim>> segments, State<Dim> state,
                                    Estimate estimate, std::int64_t most_memory)
    : network_(std::move(network)),
      join_(std::move(join)),
      segments_(std::move(segments)),
      state_(std::move(state)),
      estimate_(estimate),
      most_memory_(most_memory) {}

template <int Dim>
Expected<MapCovariances<Dim>> MapCovariances<Dim>::make(Network<Dim> network, Join<Dim> join,
                                                        std::vector<Segment<Dim>> segments, State<Dim> state, Estimate estimate,
                                                        std::int64_t most_memory) {
  MapCovariances covariances(std::move(network), std::move(join), std::move(segments), std::move(state), estimate, most_memory);
  if (!covariances.factorise()) return bad_input("the covariances are not finite: something is free to move");
  covariances.find_homes();
  return covariances;
}

template <int Dim>
bool MapCovariances<Dim>::factorise() {
  JointSystem<Dim>& system = *join_.system;
  if (estimate_ == Estimate::kPolished) {
    PolishProblem<Dim> problem(system, segments_, network_.is_private, state_);
    problem.linearise();
    return !problem.factorise(0.0);
  }
  JoinProblem<Dim> problem(std::move(system));
  problem.linearise();
  const bool is_regular = !problem.factorise(0.0);
  system = std::move(problem.system());
  return is_regular;
}

template <int Dim>
void MapCovariances<Dim>::find_homes() {
  pose_homes_.resize(network_.pose_count);
  feature_homes_.resize(network_.feature_count);
  for (Index v = 0; v < equations().variable_count(); ++v) {
    const auto place = static_cast<std::size_t>(join_.system->place_of_variable(v));
    const std::size_t poses = join_.poses.size();
    Home& home = place < poses ? pose_homes_[static_cast<std::size_t>(join_.poses[place])]
                               : feature_homes_[static_cast<std::size_t>(join_.features[place - poses])];
    home.variable = v;
  }
  for (std::size_t m = 0; m < network_.maps.size(); ++m) {
    Home home{kConstant, static_cast<Index>(m), 0};
    for (std::size_t p = 0; p < own_poses(m); ++p, ++home.own) {
      pose_homes_[static_cast<std::size_t>(segments_[m].interior[p])] = home;
    }
    for (const Index feature : network_.maps[m].private_features) {
      feature_homes_[static_cast<std::size_t>(feature)] = home;
      ++home.own;
    }
  }
}

template <int Dim>
Expected<OwnGivenShared<Dim>> MapCovariances<Dim>::own_of(std::size_t map) const {
  if (segments_.empty()) return own_given_shared(network_.maps[map], state_);
  const Segment<Dim>& segment = segments_[map];
  LiveSegment<Dim> live(segment, network_.is_private, equations(), join_.system->map_variables(map), 0,
                        values_of(segment, state_));
  live.linearise();
  if (!live.eliminate(0.0)) return bad_input("the covariances inside a local map are not finite: something is free to move");
  return live.own_given_shared();
}

template <int Dim>
std::vector<Eigen::Index> MapCovariances<Dim>::shared_entries(std::size_t map) const {
  std::vector<Eigen::Index> entries;
  for (const Index v : join_.system->map_variables(map)) {
    const int dof = v == kConstant ? kPoseDof<Dim> : equations().dof(v);  // only poses are held
    for (int i = 0; i < dof; ++i) entries.push_back(v == kConstant ? -1 : equations().offset(v) + i);
  }
  return entries;
}

template <int Dim>
Expected<void> MapCovariances<Dim>::carry_own(std::size_t map, OwnRows asked, Triplets& J_transposed,
                                              Eigen::MatrixXd& noise) const {
  const auto own = own_of(map);
  if (!own) return tl::unexpected(own.error());
  std::sort(asked.begin(), asked.end());
  const std::vector<Eigen::Index> entries = shared_entries(map);
  std::vector<Eigen::Index> indices;
  std::vector<Eigen::Index> rows;
  for (const auto& [k, row] : asked) {
    indices.push_back(k);
    for (int i = 0; i < own->dof(k); ++i) {
      rows.push_back(row + i);
      for (std::size_t s = 0; s < entries.size(); ++s) {
        if (entries[s] < 0) continue;
        J_transposed.emplace_back(entries[s], row + i, own->gain(own->row(k) + i, static_cast<Eigen::Index>(s)));
      }
    }
  }
  noise(rows, rows) = own->covariance(indices);
  return {};
}

template <int Dim>
Expected<Eigen::MatrixXd> MapCovariances<Dim>::joint(std::span<const PoseOrFeature> variables) const {
  Triplets J_transposed;
  std::map<Index, OwnRows> own_rows;  // per map
  Eigen::Index size = 0;
  for (const PoseOrFeature& variable : variables) {
    const Home& at = home(variable);
    const int dof = variable.is_pose ? kPoseDof<Dim> : Dim;
    for (int i = 0; at.variable != kConstant && i < dof; ++i) {
      J_transposed.emplace_back(equations().offset(at.variable) + i, size + i, 1.0);
    }
    if (at.map >= 0) own_rows[at.map].emplace_back(at.own, size);
    size += dof;
  }
  const std::string what = fmt::format("the joint covariance of {} poses and features", variables.size());
  if (auto fits = check_memory(what, covariance_bytes(equations(), size), most_memory_); !fits) {
    return tl::unexpected(fits.error());
  }
  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(size, size);
  for (const auto& [map, rows] : own_rows) {
    if (auto done = carry_own(static_cast<std::size_t>(map), rows, J_transposed, noise); !done) {
      return tl::unexpected(done.error());
    }
  }
  Eigen::SparseMatrix<double> columns(equations().size(), size);
  columns.setFromTriplets(J_transposed.begin(), J_transposed.end());
  return Eigen::MatrixXd(covariance_of(equations(), columns) + noise);
}

template <int Dim>
Expected<PoseMatrix<Dim>> MapCovariances<Dim>::relative_pose(Index base, Index target) const {
  const auto covariance = joint(std::array{PoseOrFeature::pose(base), PoseOrFeature::pose(target)});
  if (!covariance) return tl::unexpected(covariance.error());
  const auto J = J_relation(state_.pose(base), state_.pose(target));
  return PoseMatrix<Dim>(J * *covariance * J.transpose());
}

template <int Dim>
Expected<PointMatrix<Dim>> MapCovariances<Dim>::relative_feature(Index base, Index feature) const {
  const auto covariance = joint(std::array{PoseOrFeature::pose(base), PoseOrFeature::feature(feature)});
  if (!covariance) return tl::unexpected(covariance.error());
  const auto J = J_relation<Dim>(state_.pose(base), state_.feature(feature));
  return PointMatrix<Dim>(J * *covariance * J.transpose());
}

template class MapCovariances<2>;
template class MapCovariances<3>;

}  // namespace mapjoin
