// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <mapjoin/check/ties.hpp>
#include <mapjoin/distributed/connectivity.hpp>

namespace mapjoin::distributed {
namespace {

/// The number of parts that are named.
constexpr std::size_t kNamed = 3;

/// Two vertices of TieVertices.
struct Tie {
  std::int32_t a = 0;
  std::int32_t b = 0;
};
template <typename F>
void fields(Tie& tie, const F& f) {
  f(tie.a);
  f(tie.b);
}

/// Ties of this rank that connect what all of its ties connect.
template <int Dim>
std::vector<Tie> forest_of(const LogPart<Dim>& part) {
  std::vector<Edge> edges;
  for_each_tie(part, [&](std::size_t a, std::size_t b) { edges.emplace_back(static_cast<Vertex>(a), static_cast<Vertex>(b)); });
  std::vector<Vertex> roots(vertices_of(part).size());
  for (std::size_t k = 0; k < roots.size(); ++k) roots[k] = static_cast<Vertex>(k);
  std::vector<Tie> forest;
  for (const Reached& reached : spanning_forest(roots.size(), edges, roots)) {
    if (!reached.edge) continue;
    const auto [a, b] = edges[*reached.edge];
    forest.push_back({static_cast<std::int32_t>(a), static_cast<std::int32_t>(b)});
  }
  return forest;
}

/// Said on the first rank, which alone has the ties of all.
template <int Dim>
Expected<void> check_connected_by(const std::vector<std::string>& forests, const LogPart<Dim>& part) {
  const TieVertices of = vertices_of(part);
  std::vector<Edge> edges;
  for (const std::string& forest : forests) {
    for (const Tie& tie : Reader(forest).take<Tie>())
      edges.emplace_back(static_cast<Vertex>(tie.a), static_cast<Vertex>(tie.b));
  }
  const Graph graph = make_graph(of.size(), edges);
  for (const FeatureIndex f : indices(part.features)) {
    if (out_degree(static_cast<Vertex>(of.feature(f)), graph) > 0) continue;
    return bad_input(fmt::format("{}: {} is never observed", part.source, to_string(part.features[f])));
  }
  std::vector<std::string> names;
  for (const std::size_t root : component_roots(graph)) names.push_back(name_of(root, part));
  if (names.size() <= 1) return {};
  const std::size_t named = std::min(names.size(), kNamed);
  return bad_input(
      fmt::format("{}: nothing ties its {} parts together; they hold {}{}; `mapjoin run` takes --parts and --associate",
                  part.source, names.size(), fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(named), ", "),
                  named < names.size() ? ", …" : ""));
}

}  // namespace

template <int Dim>
Expected<void> check_connected(const Communicator& comm, const LogPart<Dim>& part) {
  std::vector<std::string> to(static_cast<std::size_t>(comm.size()));
  to.front() = Writer().put(forest_of(part)).bytes();
  const std::vector<std::string> forests = comm.exchange(std::move(to));
  return comm.agree(comm.is_root() ? check_connected_by(forests, part) : Expected<void>());
}

template Expected<void> check_connected(const Communicator&, const LogPart<2>&);
template Expected<void> check_connected(const Communicator&, const LogPart<3>&);

}  // namespace mapjoin::distributed
