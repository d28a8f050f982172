// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/check/ties.hpp>
#include <string>

namespace mapjoin {

template <typename LogOrSet>
Expected<void> check_connected(const LogOrSet& tied) {
  constexpr std::ptrdiff_t kNamed = 3;
  const TieVertices of = vertices_of(tied);
  const Graph graph = make_graph(of.size(), ties_of(tied));
  for (const FeatureIndex f : indices(tied.features)) {
    if (out_degree(static_cast<Vertex>(of.feature(f)), graph) > 0) continue;
    return bad_input(fmt::format("{}: {} is never observed", tied.source, to_string(tied.features[f])));
  }
  std::vector<std::string> names;
  for (const std::size_t root : component_roots(graph)) names.push_back(name_of(root, tied));
  if (names.size() <= 1) return {};
  const auto named = names.begin() + std::min(std::ssize(names), kNamed);
  return bad_input(fmt::format("{}: nothing ties its {} parts together; they hold {}{}", tied.source, names.size(),
                               fmt::join(names.begin(), named, ", "), named != names.end() ? ", …" : ""));
}

template Expected<void> check_connected(const Log<2>&);
template Expected<void> check_connected(const Log<3>&);
template Expected<void> check_connected(const SubmapSet<2>&);
template Expected<void> check_connected(const SubmapSet<3>&);

}  // namespace mapjoin
