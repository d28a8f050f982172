// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/check/ties.hpp>
#include <string>

namespace mapjoin {
namespace {

/// At most this many components are named.
constexpr std::size_t kNamed = 3;

template <typename Tied>
Expected<void> check(const Tied& tied) {
  const TieVertices of = vertices_of(tied);
  const Graph graph = make_graph(of.size(), ties_of(tied));
  for (const FeatureIndex f : indices(tied.features)) {
    if (out_degree(static_cast<Vertex>(of.feature(f)), graph) > 0) continue;
    return bad_input(fmt::format("{}: {} is never observed", tied.source, to_string(tied.features[f])));
  }
  const std::vector<std::size_t> roots = component_roots(graph);
  if (roots.size() <= 1) return {};
  std::string names;
  for (std::size_t k = 0; k < std::min(roots.size(), kNamed); ++k) {
    names += (k > 0 ? ", " : "") + name_of(roots[k], tied);
  }
  return bad_input(fmt::format("{}: nothing ties its {} parts together; they hold {}{}", tied.source, roots.size(), names,
                               roots.size() > kNamed ? ", …" : ""));
}

}  // namespace

template <int Dim>
Expected<void> check_connected(const Log<Dim>& log) {
  return check(log);
}

template <int Dim>
Expected<void> check_connected(const SubmapSet<Dim>& set) {
  return check(set);
}

template Expected<void> check_connected(const Log<2>&);
template Expected<void> check_connected(const Log<3>&);
template Expected<void> check_connected(const SubmapSet<2>&);
template Expected<void> check_connected(const SubmapSet<3>&);

}  // namespace mapjoin
