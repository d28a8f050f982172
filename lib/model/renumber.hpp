// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Renumbering of the poses and features of factors.

#include <mapjoin/model/factor_graph.hpp>

namespace mapjoin {

/// An overload set with a function for each kind of index.
template <typename... Functions>
struct EachKind : Functions... {
  using Functions::operator()...;
};
template <typename... Functions>
EachKind(Functions...) -> EachKind<Functions...>;

/// Gives the poses and features of a factor the indices index_of(each); the World stays.
template <typename Factor, typename IndexOf>
void renumber(Factor& factor, const IndexOf& index_of) {
  if (factor.base != kWorld) factor.base = index_of(factor.base);
  factor.target = index_of(factor.target);
}
template <int Dim, typename IndexOf>
void renumber(LocalMap<Dim>& map, const IndexOf& index_of) {
  map.base = index_of(map.base);
  for (PoseIndex& pose : map.poses) pose = index_of(pose);
  for (FeatureIndex& feature : map.features) feature = index_of(feature);
}
/// Renumbers a graph: submaps, pose factors, feature factors, then fixed poses.
template <int Dim, typename IndexOf>
void renumber(FactorGraph<Dim>& graph, const IndexOf& index_of) {
  for (auto& map : graph.submaps) renumber(map, index_of);
  for (auto& factor : graph.pose_factors) renumber(factor, index_of);
  for (auto& factor : graph.feature_factors) renumber(factor, index_of);
  for (auto& fixed : graph.fixed) fixed.pose = index_of(fixed.pose);
}

}  // namespace mapjoin
