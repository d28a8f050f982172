// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The connected components of a graph whose edges come one by one.

#include <boost/pending/disjoint_sets.hpp>
#include <cstddef>
#include <mapjoin/graph/ties.hpp>
#include <vector>

namespace mapjoin {

/// Disjoint sets of vertices that are tied together.
class Components {
 public:
  explicit Components(std::size_t vertices)
      : parent_(vertices), rank_(vertices), is_tied_(vertices, false), sets_(rank_.data(), parent_.data()) {
    for (std::size_t v = 0; v < vertices; ++v) sets_.make_set(v);
  }

  void tie(std::size_t a, std::size_t b) {
    sets_.union_set(a, b);
    is_tied_[a] = is_tied_[b] = true;
  }
  /// Whether anything was tied to `v`.
  bool is_tied(std::size_t v) const { return is_tied_[v]; }

  /// The same for all vertices of one component.
  std::size_t root(std::size_t v) { return sets_.find_set(v); }
  /// The first vertex of each component; the World counts only where something hangs on it.
  std::vector<std::size_t> roots() {
    std::vector<std::size_t> first_of(parent_.size(), parent_.size());
    std::vector<std::size_t> firsts;
    const std::size_t world = TieVertices::kWorldVertex;
    for (std::size_t v = is_tied_[world] ? world : world + 1; v < parent_.size(); ++v) {
      std::size_t& first = first_of[sets_.find_set(v)];
      if (first != parent_.size()) continue;
      first = v;
      firsts.push_back(v);
    }
    return firsts;
  }

 private:
  std::vector<std::size_t> parent_;
  std::vector<std::size_t> rank_;
  std::vector<bool> is_tied_;
  boost::disjoint_sets<std::size_t*, std::size_t*> sets_;
};

}  // namespace mapjoin
