// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/check/ties.hpp>
#include <mapjoin/distributed/reading/log_part.hpp>

namespace mapjoin::distributed {
namespace {

/// Minimum number of poses per region: fewer are not worth one.
constexpr std::size_t kLeastPoses = 10;

/// A spanning forest of this rank's factors, as links between TieVertices.
template <int Dim>
std::vector<Link> forest_of(const LogPart<Dim>& part) {
  const std::vector<Edge> edges = ties_of(part);
  std::vector<Vertex> roots(vertices_of(part).size());
  for (std::size_t k = 0; k < roots.size(); ++k) roots[k] = static_cast<Vertex>(k);
  std::vector<Link> forest;
  for (const Reached& reached : spanning_forest(roots.size(), edges, roots)) {
    if (!reached.edge) continue;
    const auto [a, b] = edges[*reached.edge];
    forest.push_back({static_cast<std::int32_t>(a), static_cast<std::int32_t>(b)});
  }
  return forest;
}

/// Checks that the forests of all ranks, which the first rank has, connect the log.
template <int Dim>
Expected<void> check_forests(const std::vector<std::string>& forests, const LogPart<Dim>& part) {
  std::vector<Edge> edges;
  for (const std::string& forest : forests) {
    for (const Link& link : Reader(forest).take<Link>())
      edges.emplace_back(static_cast<Vertex>(link.a), static_cast<Vertex>(link.b));
  }
  return check_tied({part.source, part.poses, part.features}, edges, "; `mapjoin run` takes --parts and --associate");
}

}  // namespace

Expected<void> check_worth_it(const Communicator& comm, const std::string& source, const PoseIds& poses, std::size_t regions) {
  if (poses.empty()) return bad_input(source + ": the log has no poses");
  if (poses.size() / (kLeastPoses * static_cast<std::size_t>(comm.size())) >= regions) return {};
  const std::string of_regions = regions > 1 ? " of " + plural(regions, "region") : "";
  const std::string fewer = regions > 1 || comm.size() > 1 ? "take fewer, or " : "take ";
  return tl::unexpected(
      Error{ErrorKind::kUsage, fmt::format("{}: {} for {}{}: {}`mapjoin run` or, of stores, `mapjoin join`", source,
                                           plural(poses.size(), "pose is too few", "poses are too few"),
                                           plural(comm.size(), "rank"), of_regions, fewer)});
}

template <int Dim>
Expected<void> check_connected(const Communicator& comm, const LogPart<Dim>& part) {
  const std::vector<std::string> forests = comm.collect(Writer().put(forest_of(part)).bytes());
  return comm.agree(comm.is_root() ? check_forests(forests, part) : Expected<void>());
}

template Expected<void> check_connected(const Communicator&, const LogPart<2>&);
template Expected<void> check_connected(const Communicator&, const LogPart<3>&);

}  // namespace mapjoin::distributed
