// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <mapjoin/join/incremental/front_plan.hpp>
#include <set>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

struct Graph {
  std::vector<int> dofs;
  Cliques cliques;
};

Graph random_graph(Index count, unsigned seed) {
  testing::Random random(seed);
  Graph graph;
  const auto any = [&] { return static_cast<Index>(random.uniform(0.0, count - 1e-9)); };
  for (Index v = 0; v < count; ++v) {
    graph.dofs.push_back(v % 3 == 0 ? 3 : 2);
    graph.cliques.push_back(std::array{v});
    std::set<Index> clique = {v, any()};
    if (v % 5 == 0) clique.insert(any());
    graph.cliques.push_back(clique);
  }
  return graph;
}

bool holds_all(const PlannedFront& front, std::span<const Index> variables) {
  return std::all_of(variables.begin(), variables.end(), [&](Index v) {
    return std::count(front.frontals.begin(), front.frontals.end(), v) +
               std::count(front.separator.begin(), front.separator.end(), v) ==
           1;
  });
}

TEST(FrontPlan, IsATreeInWhichEverythingHasItsPlace) {
  for (const Index count : {1, 10, 60, 400}) {
    const Graph graph = random_graph(count, 3);
    const FrontPlan plan = plan_fronts(graph.dofs, graph.cliques, 0);
    std::vector<int> eliminated(static_cast<std::size_t>(count), 0);
    for (std::size_t k = 0; k < plan.fronts.size(); ++k) {
      const PlannedFront& front = plan.fronts[k];
      for (const Index v : front.frontals) ++eliminated[static_cast<std::size_t>(v)];
      EXPECT_EQ(front.parent < 0, front.separator.empty());
      if (front.parent < 0) continue;
      ASSERT_LT(front.parent, static_cast<Index>(k));
      EXPECT_TRUE(holds_all(plan.fronts[static_cast<std::size_t>(front.parent)], front.separator));
    }
    EXPECT_EQ(std::count(eliminated.begin(), eliminated.end(), 1), count);
    for (std::size_t c = 0; c < graph.cliques.size(); ++c) {
      EXPECT_TRUE(holds_all(plan.fronts[static_cast<std::size_t>(plan.front_of_clique[c])], graph.cliques[c]));
    }
  }
}

TEST(FrontPlan, TheLastVariablesAreEliminatedLast) {
  const Graph graph = random_graph(300, 5);
  const FrontPlan plan = plan_fronts(graph.dofs, graph.cliques, 12);
  // Above a front that eliminates one of the last there is none that eliminates another variable.
  for (const PlannedFront& front : plan.fronts) {
    const bool is_late = std::any_of(front.frontals.begin(), front.frontals.end(), [](Index v) { return v >= 288; });
    if (!is_late) continue;
    EXPECT_TRUE(std::all_of(front.separator.begin(), front.separator.end(), [](Index v) { return v >= 288; }));
  }
}

TEST(FrontPlan, AChainHasNoFill) {
  Graph chain;
  for (Index v = 0; v < 300; ++v) {
    chain.dofs.push_back(30);  // too large to be merged for their smallness
    if (v > 0) chain.cliques.push_back(std::array{v - 1, v});
  }
  for (const PlannedFront& front : plan_fronts(chain.dofs, chain.cliques, 0).fronts) {
    EXPECT_LE(front.frontals.size() + front.separator.size(), 3u);
  }
}

}  // namespace
}  // namespace mapjoin
