// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <mapjoin/localmap/condense.hpp>
#include <mapjoin/model/cost.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The rows of W of a map's poses and of the features at the given places.
template <int Dim>
std::vector<Eigen::Index> rows_of(const LocalMap<Dim>& map, const std::vector<std::size_t>& feature_places, bool with_poses) {
  std::vector<Eigen::Index> rows;
  const std::size_t poses = map.poses.size();
  for (Eigen::Index row = 0; with_poses && row < map.row(poses); ++row) rows.push_back(row);
  for (const std::size_t place : feature_places) {
    for (int i = 0; i < Dim; ++i) rows.push_back(map.row(poses + place) + i);
  }
  return rows;
}

}  // namespace

template <int Dim>
CondensedMap<Dim> condense(LocalMap<Dim> map, const std::vector<bool>& is_private) {
  std::vector<std::size_t> shared_places;
  std::vector<std::size_t> private_places;
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    (is_private[static_cast<std::size_t>(map.features[f])] ? private_places : shared_places).push_back(f);
  }
  CondensedMap<Dim> condensed{std::move(map), {}, {}, {}, {}};
  if (private_places.empty()) return condensed;
  const LocalMap<Dim>& whole = condensed.map;
  const auto o = rows_of(whole, shared_places, true);
  const auto f = rows_of(whole, private_places, false);
  const Eigen::MatrixXd W_ff = whole.information(f, f);
  const Eigen::MatrixXd W_fo = whole.information(f, o);
  const Eigen::LLT<Eigen::MatrixXd> llt(W_ff);
  if (llt.info() != Eigen::Success || !(llt.rcond() > 1e-13)) return condensed;

  condensed.gain = llt.solve(W_fo);
  condensed.private_information = W_ff;
  LocalMap<Dim> rest = whole;
  rest.features.clear();
  rest.feature_estimates.clear();
  for (const std::size_t place : shared_places) {
    rest.features.push_back(whole.features[place]);
    rest.feature_estimates.push_back(whole.feature_estimates[place]);
  }
  for (const std::size_t place : private_places) {
    condensed.private_features.push_back(whole.features[place]);
    condensed.private_estimates.push_back(whole.feature_estimates[place]);
  }
  const Eigen::MatrixXd W_oo = whole.information(o, o) - W_fo.transpose() * condensed.gain;
  rest.information = 0.5 * (W_oo + W_oo.transpose());
  condensed.map = std::move(rest);
  return condensed;
}

template <int Dim>
LocalMap<Dim> uncondensed(const CondensedMap<Dim>& condensed) {
  LocalMap<Dim> map = condensed.map;
  if (condensed.private_features.empty()) return map;
  map.features.insert(map.features.end(), condensed.private_features.begin(), condensed.private_features.end());
  map.feature_estimates.insert(map.feature_estimates.end(), condensed.private_estimates.begin(),
                               condensed.private_estimates.end());
  const Eigen::MatrixXd W_fo = condensed.private_information * condensed.gain;
  map.information.resize(W_fo.cols() + W_fo.rows(), W_fo.cols() + W_fo.rows());
  map.information << condensed.map.information + condensed.gain.transpose() * W_fo, W_fo.transpose(), W_fo,
      condensed.private_information;
  return map;
}

template <int Dim>
void recover_private_features(const CondensedMap<Dim>& condensed, State<Dim>& state) {
  if (condensed.private_features.empty()) return;
  const LocalMap<Dim>& map = condensed.map;
  const Pose<Dim> base = state.pose(map.base);
  const Eigen::VectorXd r_others = residual(
      map, base, [&](std::size_t p) { return state.pose(map.poses[p]); },
      [&](std::size_t f) { return state.feature(map.features[f]); });
  const Eigen::VectorXd r = -condensed.gain * r_others;
  for (std::size_t f = 0; f < condensed.private_features.size(); ++f) {
    const Point<Dim> p_local = condensed.private_estimates[f] - r.segment<Dim>(static_cast<Eigen::Index>(f) * Dim);
    state.features[static_cast<std::size_t>(condensed.private_features[f])] = transform(base, p_local);
  }
}

template <int Dim>
std::vector<bool> private_features(const std::vector<LocalMap<Dim>>& maps, std::vector<bool> mentioned_elsewhere) {
  std::vector<bool> once(mentioned_elsewhere.size(), false);
  for (const auto& map : maps) {
    for (const Index feature : map.features) {
      const auto f = static_cast<std::size_t>(feature);
      if (once[f]) mentioned_elsewhere[f] = true;
      once[f] = true;
    }
  }
  for (std::size_t f = 0; f < once.size(); ++f) once[f] = once[f] && !mentioned_elsewhere[f];
  return once;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                 \
  template CondensedMap<Dim> condense(LocalMap<Dim>, const std::vector<bool>&);  \
  template LocalMap<Dim> uncondensed(const CondensedMap<Dim>&);                  \
  template void recover_private_features(const CondensedMap<Dim>&, State<Dim>&); \
  template std::vector<bool> private_features(const std::vector<LocalMap<Dim>>&, std::vector<bool>);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
