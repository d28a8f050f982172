// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <mapjoin/join/graded_problem.hpp>
#include <mapjoin/join/spanning_tree.hpp>

namespace mapjoin {
namespace {

template <typename Graded, typename Observation>
void take(const std::vector<const Observation*>& own, const std::vector<const Observation*>& priors, std::vector<Graded>& out) {
  out.reserve(own.size() + priors.size());
  for (const auto* list : {&own, &priors}) {
    for (const auto* o : *list) out.push_back({*o, o->information, false});
  }
}

template <typename Graded, typename Observation>
void point_to(const std::vector<Graded>& graded, std::vector<const Observation*>& own,
              std::vector<const Observation*>& priors) {
  auto copy = graded.begin();
  for (auto* list : {&own, &priors}) {
    for (auto& o : *list) o = &(copy++)->observation;
  }
}

/// The marginal of some rows, others zero: W_LL - W_LN W_NN⁻¹ W_NL.
Eigen::MatrixXd marginal(const Eigen::MatrixXd& W, const std::vector<Eigen::Index>& L, const std::vector<Eigen::Index>& N) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(W.rows(), W.cols());
  Eigen::MatrixXd W_LL = W(L, L);
  if (!N.empty() && !L.empty()) {
    const Eigen::MatrixXd W_NL = W(N, L);
    W_LL -= W_NL.transpose() * Eigen::MatrixXd(W(N, N)).ldlt().solve(W_NL);
  }
  out(L, L) = W_LL;
  return out;
}

}  // namespace

template <int Dim>
GradedProblem<Dim>::Copies::Copies(const Piece<Dim>& original, const Gauge<Dim>& held) : piece(original), gauge(held) {
  take(piece.pose_observations, gauge.pose_priors, poses);
  take(piece.feature_observations, gauge.feature_priors, features);
  point_to(poses, piece.pose_observations, gauge.pose_priors);
  point_to(features, piece.feature_observations, gauge.feature_priors);
  maps.reserve(piece.maps.size());
  for (auto& map : piece.maps) {
    maps.push_back({*map, map->information, {}});
    map = &maps.back().map;
  }
}

template <int Dim>
GradedProblem<Dim>::GradedProblem(const Piece<Dim>& piece, const Gauge<Dim>& gauge)
    : copies_(piece, gauge), join_(copies_.piece, copies_.gauge) {
  take_tree();
}

template <int Dim>
void GradedProblem<Dim>::take_tree() {
  const std::size_t first_map = copies_.poses.size() + copies_.features.size();
  std::vector<std::vector<bool>> is_in_tree(copies_.maps.size());
  for (std::size_t m = 0; m < copies_.maps.size(); ++m) {
    is_in_tree[m].resize(copies_.maps[m].map.poses.size() + copies_.maps[m].map.features.size());
  }
  const SpanningTree tree = spanning_tree(join_.system());
  for (const auto* edges : {&tree.poses, &tree.features}) {
    for (const TreeEdge& edge : *edges) {
      if (!edge.observation) continue;
      const std::size_t clique = edge.observation->clique;
      if (clique < copies_.poses.size()) {
        copies_.poses[clique].is_quadratic = true;
      } else if (clique < first_map) {
        copies_.features[clique - copies_.poses.size()].is_quadratic = true;
      } else {
        is_in_tree[clique - first_map][static_cast<std::size_t>(edge.observation->target)] = true;
      }
    }
  }
  for (std::size_t m = 0; m < copies_.maps.size(); ++m) {
    GradedMap& graded = copies_.maps[m];
    std::vector<Eigen::Index> linear, rest;
    Eigen::Index row = 0;
    for (std::size_t t = 0; t < is_in_tree[m].size(); ++t) {
      const int dof = t < graded.map.poses.size() ? kPoseDof<Dim> : Dim;
      for (int i = 0; i < dof; ++i) (is_in_tree[m][t] ? linear : rest).push_back(row++);
    }
    graded.quadratic = marginal(graded.whole, linear, rest);
  }
}

template <int Dim>
void GradedProblem<Dim>::set_share(double share) {
  for (auto& o : copies_.poses) o.observation.information = (o.is_quadratic ? 1.0 : share) * o.whole;
  for (auto& o : copies_.features) o.observation.information = (o.is_quadratic ? 1.0 : share) * o.whole;
  for (auto& m : copies_.maps) m.map.information = share * m.whole + (1.0 - share) * m.quadratic;
}

template <int Dim>
std::vector<PathPoint> lead_gradually(const Gauge<Dim>& gauge, JoinedState state, const MinimiseOptions& options,
                                      const std::stop_token& stop, Piece<Dim>& piece) {
  std::vector<PathPoint> path;
  GradedProblem<Dim> graded(piece, gauge);
  for (const double share : {0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1}) {
    if (stop.stop_requested()) break;
    graded.set_share(share);
    path.push_back({share, minimise_join(graded.join(), state, options, stop)});
  }
  piece.state = graded.join().estimate();
  return path;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                         \
  template class GradedProblem<Dim>;                                                                     \
  template std::vector<PathPoint> lead_gradually(const Gauge<Dim>&, JoinedState, const MinimiseOptions&, \
                                                 const std::stop_token&, Piece<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
