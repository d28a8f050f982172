// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/picture/load.hpp>
#include <mapjoin/join/join_problem.hpp>
#include <mapjoin/join/schedule.hpp>

namespace mapjoin::apps {
namespace {

constexpr std::size_t kLeastStops = 12;
constexpr std::size_t kMostStops = 100;
constexpr std::size_t kMostPlaces = 500'000;  // of all stops together: 6 MB

/// How many stretches to join between two stops.
template <int Dim>
std::size_t between_stops(const Network<Dim>& network) {
  const auto count_of = [](const std::vector<bool>& flags, bool value) {
    return static_cast<std::size_t>(std::count(flags.begin(), flags.end(), value));
  };
  const std::size_t places = count_of(network.is_joined, true) + count_of(network.is_private, false);
  const std::size_t stops = std::clamp(2 * kMostPlaces / std::max<std::size_t>(places, 1), kLeastStops, kMostStops);
  return (network.stretches.size() + stops - 1) / stops;
}

}  // namespace

template <int Dim>
std::vector<JoinStop<Dim>> join_stops(const Network<Dim>& network, const GlobalMap<Dim>& map,
                                      const std::function<void(std::size_t, std::size_t)>& progress,
                                      const std::stop_token& stop) {
  std::vector<JoinStop<Dim>> stops;
  const JoinWatch<Dim> watch = [&](std::size_t stretches, const JoinedPieces<Dim>& joined) {
    const Piece<Dim>& piece = joined.pieces.front();
    const Pose<Dim>& first = map.poses[static_cast<std::size_t>(piece.poses.front())];
    const Pose<Dim> frame = compose(first, inverse(piece.state.poses.front()));
    stops.push_back({stretches, piece_chi2(piece), piece.poses, moved(frame, piece.state)});
  };
  watch_join(network, between_stops(network), watch, progress, stop);
  return stops;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                       \
  template std::vector<JoinStop<Dim>> join_stops(const Network<Dim>&, const GlobalMap<Dim>&,           \
                                                 const std::function<void(std::size_t, std::size_t)>&, \
                                                 const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
