// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <mapjoin/localmap/marginalise.hpp>
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
MarginalisedMap<Dim> marginalise(LocalMap<Dim> map, const Table<FeatureIndex, bool>& is_local) {
  std::vector<std::size_t> shared_places;
  std::vector<std::size_t> local_places;
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    (is_local[map.features[f]] ? local_places : shared_places).push_back(f);
  }
  MarginalisedMap<Dim> marginalised{std::move(map), {}, {}, {}, {}};
  if (local_places.empty()) return marginalised;
  const LocalMap<Dim>& whole = marginalised.map;
  const auto o = rows_of(whole, shared_places, true);
  const auto f = rows_of(whole, local_places, false);
  const Eigen::MatrixXd W_ff = whole.information(f, f);
  const Eigen::MatrixXd W_fo = whole.information(f, o);
  const Eigen::LLT<Eigen::MatrixXd> llt(W_ff);
  if (llt.info() != Eigen::Success || !(llt.rcond() > 1e-13)) return marginalised;

  marginalised.gain = llt.solve(W_fo);
  marginalised.local_information = W_ff;
  LocalMap<Dim> rest = whole;
  rest.features.clear();
  rest.feature_estimates.clear();
  for (const std::size_t place : shared_places) {
    rest.features.push_back(whole.features[place]);
    rest.feature_estimates.push_back(whole.feature_estimates[place]);
  }
  for (const std::size_t place : local_places) {
    marginalised.local_features.push_back(whole.features[place]);
    marginalised.local_estimates.push_back(whole.feature_estimates[place]);
  }
  const Eigen::MatrixXd W_oo = whole.information(o, o) - W_fo.transpose() * marginalised.gain;
  rest.information = 0.5 * (W_oo + W_oo.transpose());
  marginalised.map = std::move(rest);
  return marginalised;
}

template <int Dim>
LocalMap<Dim> restored(const MarginalisedMap<Dim>& marginalised) {
  LocalMap<Dim> map = marginalised.map;
  if (marginalised.local_features.empty()) return map;
  map.features.insert(map.features.end(), marginalised.local_features.begin(), marginalised.local_features.end());
  map.feature_estimates.insert(map.feature_estimates.end(), marginalised.local_estimates.begin(),
                               marginalised.local_estimates.end());
  const Eigen::MatrixXd W_fo = marginalised.local_information * marginalised.gain;
  map.information.resize(W_fo.cols() + W_fo.rows(), W_fo.cols() + W_fo.rows());
  map.information << marginalised.map.information + marginalised.gain.transpose() * W_fo, W_fo.transpose(), W_fo,
      marginalised.local_information;
  return map;
}

template <int Dim>
void recover_local_features(const MarginalisedMap<Dim>& marginalised, Values<Dim>& state) {
  if (marginalised.local_features.empty()) return;
  const LocalMap<Dim>& map = marginalised.map;
  const Pose<Dim> base = state.pose(map.base);
  const Eigen::VectorXd r_others = residual(
      map, base, [&](std::size_t p) { return state.pose(map.poses[p]); },
      [&](std::size_t f) { return state.features[map.features[f]]; });
  const Eigen::VectorXd r = -marginalised.gain * r_others;
  for (std::size_t f = 0; f < marginalised.local_features.size(); ++f) {
    const Point<Dim> p_local = marginalised.local_estimates[f] - r.segment<Dim>(static_cast<Eigen::Index>(f) * Dim);
    state.features[marginalised.local_features[f]] = transform(base, p_local);
  }
}

template <int Dim>
Table<FeatureIndex, bool> local_features(const std::vector<LocalMap<Dim>>& maps,
                                         Table<FeatureIndex, bool> referenced_elsewhere) {
  Table<FeatureIndex, bool> once(referenced_elsewhere.size(), false);
  for (const auto& map : maps) {
    for (const FeatureIndex f : map.features) {
      if (once[f]) referenced_elsewhere[f] = true;
      once[f] = true;
    }
  }
  for (const FeatureIndex f : indices(once)) once[f] = once[f] && !referenced_elsewhere[f];
  return once;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                              \
  template MarginalisedMap<Dim> marginalise(LocalMap<Dim>, const Table<FeatureIndex, bool>&); \
  template LocalMap<Dim> restored(const MarginalisedMap<Dim>&);                               \
  template void recover_local_features(const MarginalisedMap<Dim>&, Values<Dim>&);            \
  template Table<FeatureIndex, bool> local_features(const std::vector<LocalMap<Dim>>&, Table<FeatureIndex, bool>);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
