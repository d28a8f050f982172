// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <boost/graph/adjacency_matrix.hpp>
#include <boost/graph/breadth_first_search.hpp>
#include <boost/graph/bron_kerbosch_all_cliques.hpp>
#include <boost/graph/connected_components.hpp>
#include <boost/graph/depth_first_search.hpp>
#include <boost/graph/kruskal_min_spanning_tree.hpp>
#include <iterator>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/model/lists.hpp>

namespace mapjoin {
namespace {

/// Lists the vertices that a walk over a forest reaches. `numbers` are the numbers of the forest's edges in the whole graph.
class Recorder : public boost::default_bfs_visitor {
 public:
  Recorder(const std::vector<std::uint32_t>& numbers, std::vector<Reached>& reached) : numbers_(&numbers), reached_(&reached) {}
  void tree_edge(Graph::edge_descriptor edge, const Graph& forest) const {
    reached_->push_back({target(edge, forest), (*numbers_)[forest[edge].number]});
  }

 private:
  const std::vector<std::uint32_t>* numbers_;
  std::vector<Reached>* reached_;
};

/// Finds bridges: the edges of a depth-first forest that no edge from below leads back over (Tarjan, 1974).
class BridgeFinder : public boost::default_dfs_visitor {
 public:
  struct Visit {
    std::uint32_t time = 0;
    std::uint32_t earliest = 0;         // time of the earliest vertex that edges from here and from below lead back to
    std::optional<std::uint32_t> edge;  // by which the walk came, from the vertex `above`
    Vertex above = 0;
  };

  BridgeFinder(std::vector<Visit>& visits, std::vector<bool>& is_bridge) : visits_(&visits), is_bridge_(&is_bridge) {}
  void tree_edge(Graph::edge_descriptor edge, const Graph& graph) const {
    Visit& below = visit(target(edge, graph));
    below.edge = graph[edge].number;
    below.above = source(edge, graph);
  }
  void discover_vertex(Vertex v, const Graph&) { visit(v).time = visit(v).earliest = time_++; }
  void back_edge(Graph::edge_descriptor edge, const Graph& graph) const {
    Visit& from = visit(source(edge, graph));
    if (from.edge != graph[edge].number) from.earliest = std::min(from.earliest, visit(target(edge, graph)).time);
  }
  void finish_vertex(Vertex v, const Graph&) const {
    const Visit& of_v = visit(v);
    if (!of_v.edge) return;
    (*is_bridge_)[*of_v.edge] = of_v.earliest == of_v.time;
    Visit& above = visit(of_v.above);
    above.earliest = std::min(above.earliest, of_v.earliest);
  }

 private:
  Visit& visit(Vertex v) const { return (*visits_)[v]; }

  std::vector<Visit>* visits_;
  std::vector<bool>* is_bridge_;
  std::uint32_t time_ = 0;
};

/// Keeps the largest clique.
struct LargestClique {
  std::vector<Vertex>* largest;
  template <typename Clique, typename AnyGraph>
  void clique(const Clique& clique, const AnyGraph&) const {
    if (clique.size() > largest->size()) largest->assign(clique.begin(), clique.end());
  }
};

/// The numbers of the edges of a spanning forest, ascending.
std::vector<std::uint32_t> forest_edges(const Graph& graph) {
  std::vector<Graph::edge_descriptor> edges;
  kruskal_minimum_spanning_tree(
      graph, std::back_inserter(edges),
      boost::weight_map(get(&EdgeNumber::number, graph)).vertex_index_map(get(boost::vertex_index, graph)));
  std::vector<std::uint32_t> numbers;
  for (const auto& edge : edges) numbers.push_back(graph[edge].number);
  return numbers;
}

}  // namespace

Graph make_graph(std::size_t vertices, const std::vector<Edge>& edges) {
  std::vector<Edge> both_ways;
  std::vector<EdgeNumber> numbers;
  both_ways.reserve(2 * edges.size());
  numbers.reserve(2 * edges.size());
  for (std::uint32_t e = 0; e < edges.size(); ++e) {
    both_ways.push_back(edges[e]);
    both_ways.emplace_back(edges[e].second, edges[e].first);
    numbers.insert(numbers.end(), 2, {e});
  }
  return {boost::edges_are_unsorted_multi_pass, both_ways.begin(), both_ways.end(), numbers.begin(),
          static_cast<Vertex>(vertices)};
}

std::vector<std::uint32_t> components_of(const Graph& graph) {
  std::vector<std::uint32_t> component(num_vertices(graph));
  connected_components(graph, boost::make_iterator_property_map(component.begin(), get(boost::vertex_index, graph)));
  return component;
}

std::vector<bool> bridges_of(std::size_t vertices, const std::vector<Edge>& edges) {
  std::vector<bool> is_bridge(edges.size());
  std::vector<BridgeFinder::Visit> visits(vertices);
  depth_first_search(make_graph(vertices, edges), boost::visitor(BridgeFinder(visits, is_bridge)));
  return is_bridge;
}

std::vector<Reached> spanning_forest(std::size_t vertices, const std::vector<Edge>& edges, const std::vector<Vertex>& roots) {
  const std::vector<std::uint32_t> numbers = forest_edges(make_graph(vertices, edges));
  std::vector<Edge> kept;
  for (const std::uint32_t e : numbers) kept.push_back(edges[e]);
  const Graph forest = make_graph(vertices, kept);

  std::vector<Reached> reached;
  std::vector<boost::default_color_type> colors(vertices, boost::white_color);
  const auto color = boost::make_iterator_property_map(colors.begin(), get(boost::vertex_index, forest));
  boost::queue<Vertex> front;
  for (const Vertex root : roots) {
    if (colors[root] != boost::white_color) continue;
    reached.push_back({root, std::nullopt});
    breadth_first_visit(forest, root, front, Recorder(numbers, reached), color);
  }
  return reached;
}

std::vector<Vertex> largest_clique(const std::vector<Edge>& edges) {
  std::vector<Vertex> vertices;
  for (const auto& [a, b] : edges) vertices.insert(vertices.end(), {a, b});
  make_distinct(vertices);
  const auto place_of = [&](Vertex v) {
    return static_cast<std::size_t>(std::ranges::lower_bound(vertices, v) - vertices.begin());
  };
  boost::adjacency_matrix<boost::undirectedS> graph(vertices.size());
  for (const auto& [a, b] : edges) add_edge(place_of(a), place_of(b), graph);
  std::vector<Vertex> largest;
  bron_kerbosch_all_cliques(graph, LargestClique{&largest});
  std::ranges::transform(largest, largest.begin(), [&](Vertex place) { return vertices[place]; });
  std::ranges::sort(largest);
  return largest;
}

}  // namespace mapjoin
