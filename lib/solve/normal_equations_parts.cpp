// SPDX-License-Identifier: BSD-3-Clause
// How the cliques of the normal equations are added up on all threads.

#include <algorithm>
#include <bit>
#include <limits>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// A part of the cliques that is worth a piece of work has so many slots at least; there are so many parts at most.
constexpr std::size_t kSlotsPerPart = 1000;
constexpr std::size_t kMostParts = 16;
/// As many colours as a word has bits; cliques for which they do not suffice are added one after the other.
constexpr int kColours = 64;

}  // namespace

std::vector<std::uint32_t> NormalEquations::cut_places(const std::vector<Index>& first_places) {
  std::vector<std::size_t> slots_at(order_.size() + 1, 0);  // of the cliques that begin at each place
  std::size_t all_slots = 0;
  for (std::size_t c = 0; c < cliques_.size(); ++c) {
    if (cliques_[c].size() > 2) continue;
    slots_at[static_cast<std::size_t>(first_places[c])] += cliques_[c].size();
    all_slots += cliques_[c].size();
  }
  const std::size_t per_part = std::max(kSlotsPerPart, all_slots / kMostParts + 1);
  std::vector<std::uint32_t> part_of(order_.size() + 1, 0);
  std::uint32_t part = 0;
  std::size_t slots = 0;
  for (std::size_t k = 0; k < order_.size(); ++k) {
    if (slots >= per_part) {
      ++part;
      slots = 0;
    }
    part_of[k] = part;
    slots += slots_at[k];
  }
  parts_.assign(part + 1, {});
  return part_of;
}

void NormalEquations::share_out_cliques() {
  std::vector<Index> first_places(cliques_.size(), 0);
  for (std::size_t c = 0; c < cliques_.size(); ++c) {
    Index first = static_cast<Index>(order_.size());
    for (const Index v : cliques_[c]) {
      if (v != kConstant) first = std::min(first, place(v));
    }
    first_places[c] = first;
  }
  const std::vector<std::uint32_t> part_of = cut_places(first_places);
  for (std::size_t c = 0; c < cliques_.size(); ++c) {
    if (cliques_[c].size() > 2) continue;
    parts_[part_of[static_cast<std::size_t>(first_places[c])]].cliques.push_back(static_cast<std::uint32_t>(c));
  }

  sums_.assign(cliques_.variables.size(), kOwn);
  std::vector<std::uint32_t> last_part(dofs_.size(), std::numeric_limits<std::uint32_t>::max());
  std::vector<std::int32_t> begin(dofs_.size());
  for (std::uint32_t p = 0; p < parts_.size(); ++p) {
    Part& part = parts_[p];
    for (const std::uint32_t c : part.cliques) {
      for (auto slot = cliques_.begin[c]; slot < cliques_.begin[c + 1]; ++slot) {
        const Index variable = cliques_.variables[static_cast<std::size_t>(slot)];
        if (variable == kConstant || part_of[static_cast<std::size_t>(place(variable))] == p) continue;
        const auto v = static_cast<std::size_t>(variable);
        if (std::exchange(last_part[v], p) != p) {
          begin[v] = part.sums;
          part.others.emplace_back(variable, part.sums);
          part.sums += dofs_[v] * (dofs_[v] + 1);
        }
        sums_[static_cast<std::size_t>(slot)] = begin[v];
      }
    }
  }
}

void NormalEquations::colour_large_cliques() {
  large_cliques_.assign(kColours + 1, {});
  std::vector<std::uint64_t> colours_of(dofs_.size(), 0);  // of the cliques that have each variable
  for (std::size_t c = 0; c < cliques_.size(); ++c) {
    if (cliques_[c].size() <= 2) continue;
    std::uint64_t taken = 0;
    for (const Index v : cliques_[c]) taken |= v == kConstant ? 0 : colours_of[static_cast<std::size_t>(v)];
    const int colour = std::countr_one(taken);
    large_cliques_[static_cast<std::size_t>(colour)].push_back(static_cast<std::uint32_t>(c));
    if (colour == kColours) continue;
    for (const Index v : cliques_[c]) {
      if (v != kConstant) colours_of[static_cast<std::size_t>(v)] |= std::uint64_t{1} << colour;
    }
  }
}

double NormalEquations::accumulate_cliques(const std::function<double(std::size_t, Sink)>& f) {
  std::vector<std::vector<double>> waiting(parts_.size());
  double sum = parallel_sum(parts_.size(), 1, [&](std::size_t p) {
    waiting[p].assign(static_cast<std::size_t>(parts_[p].sums), 0.0);
    double part = 0.0;
    for (const std::uint32_t clique : parts_[p].cliques) part += f(clique, {*this, clique, waiting[p].data()});
    return part;
  });
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    for (const auto& [variable, begin] : parts_[p].others) {
      const double* sums = waiting[p].data() + begin;
      add(variable, variable, 0, Eigen::Map<const Eigen::MatrixXd>(sums, dof(variable), dof(variable)));
      add_rhs(variable, Eigen::Map<const Eigen::VectorXd>(sums + dof(variable) * dof(variable), dof(variable)));
    }
  }
  const auto f_of = [&](std::uint32_t clique) { return f(clique, sink(clique)); };
  for (int colour = 0; colour < kColours; ++colour) {
    const auto& cliques = large_cliques_[static_cast<std::size_t>(colour)];
    sum += parallel_sum(cliques.size(), 1, [&](std::size_t k) { return f_of(cliques[k]); });
  }
  for (const std::uint32_t clique : large_cliques_[kColours]) sum += f_of(clique);
  return sum;
}

}  // namespace mapjoin
