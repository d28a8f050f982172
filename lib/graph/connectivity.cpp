// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/graph/components.hpp>
#include <mapjoin/graph/connectivity.hpp>
#include <mapjoin/graph/ties.hpp>
#include <string>

namespace mapjoin {
namespace {

/// At most this many components are named.
constexpr std::size_t kNamed = 3;

template <typename Tied>
Expected<void> check(const Tied& tied) {
  const TieVertices of = vertices_of(tied);
  Components components(of.size());
  for_each_tie(tied, [&](std::size_t a, std::size_t b) { components.tie(a, b); });
  for (std::size_t f = 0; f < of.features; ++f) {
    if (components.is_tied(of.feature(static_cast<Index>(f)))) continue;
    return bad_input(fmt::format("{}: {} is never observed", tied.source, to_string(tied.features[f])));
  }
  const auto roots = components.roots();
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
Expected<void> check_connected(const MapSet<Dim>& set) {
  return check(set);
}

template Expected<void> check_connected(const Log<2>&);
template Expected<void> check_connected(const Log<3>&);
template Expected<void> check_connected(const MapSet<2>&);
template Expected<void> check_connected(const MapSet<3>&);

}  // namespace mapjoin
