// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/graded_problem.hpp>
#include <mapjoin/join/spanning_tree.hpp>
#include <mapjoin/model/marginal_information.hpp>

namespace mapjoin {
namespace {

/// Copies observations, and has copies of their lists point to the copies.
template <typename Graded, typename Observation>
void copy(std::vector<const Observation*>& own, std::vector<const Observation*>& priors, std::vector<Graded>& out) {
  out.reserve(own.size() + priors.size());  // addresses stay
  for (auto* list : {&own, &priors}) {
    for (const Observation*& o : *list) {
      out.push_back({o, *o});
      o = &out.back().weighted;
    }
  }
}

}  // namespace

template <int Dim>
GradedProblem<Dim>::GradedProblem(JoinProblem<Dim>& join, const Piece<Dim>& piece, const Gauge<Dim>& gauge)
    : join_(join), piece_(piece), gauge_(gauge), weighted_piece_(piece), weighted_gauge_(gauge) {
  copy(weighted_piece_.factors.pose_factors, weighted_gauge_.priors.pose_factors, poses_);
  copy(weighted_piece_.factors.feature_factors, weighted_gauge_.priors.feature_factors, features_);
  maps_.reserve(piece.factors.submaps.size());  // addresses stay
  for (const LocalMap<Dim>*& map : weighted_piece_.factors.submaps) {
    maps_.push_back({map, *map});
    map = &maps_.back().weighted;
  }
  take_tree();
}

/// What the tree hangs by is quadratic.
template <int Dim>
void GradedProblem<Dim>::take_tree() {
  using Source = typename JointSystem<Dim>::Source;
  std::vector<std::vector<bool>> is_in_tree;  // per map and target
  for (const GradedMap& map : maps_) is_in_tree.emplace_back(map.whole->poses.size() + map.whole->features.size());
  const SpanningTree tree = spanning_tree(join_.system());
  for (const auto* edges : {&tree.poses, &tree.features}) {
    for (const TreeEdge& edge : *edges) {
      if (!edge.observation) continue;
      const Source source = join_.system().source_of(edge.observation->clique);
      if (source.kind == Source::kPoseObservation) poses_[source.place].is_quadratic = true;
      if (source.kind == Source::kFeatureObservation) features_[source.place].is_quadratic = true;
      if (source.kind == Source::kMap) is_in_tree[source.place][edge.observation->target] = true;
    }
  }
  for (std::size_t m = 0; m < maps_.size(); ++m) {
    const LocalMap<Dim>& whole = *maps_[m].whole;
    std::vector<Eigen::Index> rest;
    for (std::size_t t = 0; t < is_in_tree[m].size(); ++t) {
      auto& rows = is_in_tree[m][t] ? maps_[m].tree_rows : rest;
      for (Eigen::Index row = whole.row(t); row < whole.row(t + 1); ++row) rows.push_back(row);
    }
    maps_[m].quadratic = marginal_information(whole.information, maps_[m].tree_rows, rest);
  }
}

template <int Dim>
void GradedProblem<Dim>::set_share(double share) {
  for (auto& o : poses_) o.weighted.information = (o.is_quadratic ? 1.0 : share) * o.whole->information;
  for (auto& o : features_) o.weighted.information = (o.is_quadratic ? 1.0 : share) * o.whole->information;
  for (auto& m : maps_) {
    m.weighted.information = share * m.whole->information;
    m.weighted.information(m.tree_rows, m.tree_rows) += (1.0 - share) * m.quadratic;
  }
  const bool is_whole = share == 1.0;
  join_.system().observe(is_whole ? piece_ : weighted_piece_, is_whole ? gauge_ : weighted_gauge_);
}

template <int Dim>
std::vector<PathPoint> lead_gradually(JoinProblem<Dim>& join, const Piece<Dim>& piece, const Gauge<Dim>& gauge,
                                      JoinedState state, const MinimiseOptions& options, const std::stop_token& stop) {
  std::vector<PathPoint> path;
  GradedProblem<Dim> graded(join, piece, gauge);
  for (const double share : {0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1}) {
    if (stop.stop_requested()) break;
    graded.set_share(share);
    path.push_back({share, minimise_join(join, state, options, stop)});
  }
  graded.set_share(1.0);
  return path;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                       \
  template class GradedProblem<Dim>;                                                                                   \
  template std::vector<PathPoint> lead_gradually(JoinProblem<Dim>&, const Piece<Dim>&, const Gauge<Dim>&, JoinedState, \
                                                 const MinimiseOptions&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
