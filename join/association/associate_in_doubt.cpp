// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <mapjoin/join/association/associate_in_doubt.hpp>
#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/robust/selection.hpp>
#include <mapjoin/join/robust/support/closure_support.hpp>
#include <numeric>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// The most times that features are found, each time with the closures that fit those found before.
constexpr int kMostRounds = 3;

/// The inliers of data that may be in parts.
template <typename Data>
Expected<Data> inliers_of(const Data& data, const RobustOptions& robust, const std::stop_token& stop) {
  Data held = data;
  hold_parts(held);
  return find_inliers(held, robust, stop).map([&](Inliers<Data> inliers) {
    inliers.input.graph.fixed = data.graph.fixed;
    return std::move(inliers.input);
  });
}

/// The associations of all sightings of `data`, found by some of them, at least one of each name: a name is one feature within
/// a part. Those that took no part have no match.
template <typename Data>
Associated<Data> of_all_sightings(const Data& data, const std::vector<NamedSighting>& some, Associated<Data> found) {
  const PartNumbers parts = part_numbers_of(data);
  const auto named = [&](const NamedSighting& seen) { return std::pair(parts.of_pose[seen.base], seen.name); };
  std::map<std::pair<std::uint32_t, FeatureIndex>, std::size_t> joined;
  for (std::size_t s = 0; s < some.size(); ++s) joined[named(some[s])] = found.sightings[s].joined.key;
  const std::vector<NamedSighting> seen = named_sightings(data);
  std::vector<std::size_t> labels;
  for (const NamedSighting& one : seen) labels.push_back(joined.at(named(one)));
  const Identities identities(std::vector<Sighting>(seen.size()), std::move(labels));
  found.data = renamed(data, identities);

  std::vector<AssociatedSighting> all;
  std::size_t next = 0;  // of those that took part
  for (std::size_t s = 0; s < seen.size(); ++s) {
    const bool took_part = next < some.size() && some[next].base == seen[s].base && some[next].name == seen[s].name;
    AssociatedSighting& sighting = all.emplace_back();
    if (took_part) sighting = found.sightings[next++];
    sighting.base = data.poses[seen[s].base];
    sighting.name = data.features[seen[s].name];
    sighting.joined = found.data.features[identities.feature_of(s)];
    sighting.gate = found.sightings.front().gate;
  }
  found.sightings = std::move(all);
  return found;
}

template <typename Data>
Expected<Associated<Data>> associate_by_names(const Data& data, const AssociationOptions& options, const RobustOptions& robust,
                                              const std::stop_token& stop) {
  return inliers_of(data, robust, stop).and_then([&](const Data& inliers) {
    return associate(inliers, options, stop).map([&](Associated<Data> found) {
      return of_all_sightings(data, named_sightings(inliers), std::move(found));
    });
  });
}

/// The log without closures, but for the likeliest of those that alone tie its poses.
template <int Dim>
Log<Dim> with_few_closures(const Log<Dim>& log, const std::stop_token& stop) {
  const std::vector<double> odds = supported(OdometryChain<Dim>(log), log.closures(), stop).odds;
  std::vector<std::size_t> all(odds.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const Log<Dim> nameless = selected(log, all, std::vector<bool>(log.observations().size()));
  return selected(log, tied_together(nameless, odds, std::vector<bool>(odds.size())), {});
}

/// True if both logs have edges between the same poses.
template <int Dim>
bool have_same_edges(const Log<Dim>& one, const Log<Dim>& other) {
  const auto ends = [](const PoseFactor<Dim>& edge) { return std::pair(edge.base, edge.target); };
  return std::ranges::equal(one.graph.pose_factors, other.graph.pose_factors, {}, ends, ends);
}

template <int Dim>
Expected<Associated<Log<Dim>>> associate_doubting_closures(const Log<Dim>& log, const AssociationOptions& options,
                                                           const RobustOptions& robust, const std::stop_token& stop) {
  Log<Dim> believed = with_few_closures(log, stop);
  for (int round = 1;; ++round) {
    auto found = associate(believed, options, stop);
    if (!found) return found;
    found->data.graph.pose_factors = log.graph.pose_factors;
    if (round == kMostRounds) return found;
    auto inliers = inliers_of(found->data, robust, stop);
    if (!inliers) return tl::unexpected(inliers.error());
    if (have_same_edges(*inliers, believed)) return found;
    believed.graph.pose_factors = std::move(inliers->graph.pose_factors);
  }
}

}  // namespace

template <int Dim>
Expected<Associated<Log<Dim>>> associate_in_doubt(const Log<Dim>& log, const AssociationOptions& options,
                                                  const RobustOptions& robust, const std::stop_token& stop) {
  if (options.names_hold) return associate_by_names(log, options, robust, stop);
  if (log.closures().empty()) return associate(log, options, stop);
  return associate_doubting_closures(log, options, robust, stop);
}

template <int Dim>
Expected<Associated<SubmapSet<Dim>>> associate_in_doubt(const SubmapSet<Dim>& set, const AssociationOptions& options,
                                                        const RobustOptions& robust, const std::stop_token& stop) {
  return options.names_hold ? associate_by_names(set, options, robust, stop) : associate(set, options, stop);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                               \
  template Expected<Associated<Log<Dim>>> associate_in_doubt(const Log<Dim>&, const AssociationOptions&, const RobustOptions&, \
                                                             const std::stop_token&);                                          \
  template Expected<Associated<SubmapSet<Dim>>> associate_in_doubt(const SubmapSet<Dim>&, const AssociationOptions&,           \
                                                                   const RobustOptions&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
