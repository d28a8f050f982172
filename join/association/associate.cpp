// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/association/identity_search.hpp>
#include <mapjoin/join/association/tracking/log_tracking.hpp>
#include <mapjoin/join/association/tracking/sighting_density.hpp>
#include <mapjoin/model/information.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// Observations per segment, or slightly more: enough to estimate its features well, few enough for accurate odometry.
constexpr std::size_t kObservationsPerSegment = 150;

/// Splits a log into segments of equally many poses, with about kObservationsPerSegment observations each.
template <int Dim>
Split split_evenly(const Log<Dim>& log) {
  const std::size_t observations = std::max<std::size_t>(1, log.observations().size());
  const std::size_t poses = 1 + kObservationsPerSegment * log.poses.size() / observations;
  return split(log, {SplitRule::kPoses, static_cast<double>(std::max<std::size_t>(2, poses))});
}

tl::unexpected<Error> of_named_prior(const std::string& source) {
  return bad_input(
      source +
      ": has a prior of a feature, which --associate cannot find by its name again; leave out that prior, or --associate");
}

/// Makes positions of all observations that give none; false if there are none.
template <int Dim, template <int> typename Source>
bool give_positions(Source<Dim>& data) {
  bool any = false;
  for (FeatureFactor<Dim>& o : data.graph.feature_factors) {
    if (information_rank<Dim>(o.information) == Dim) continue;
    const double most = o.information.diagonal().maxCoeff();
    o.information = (most > 0.0 ? most : 1.0) * PointMatrix<Dim>::Identity();
    any = true;
  }
  return any;
}

/// The error of `join` on data in which features are the same as far as is known; in words of its cause if the join succeeds
/// once all observations give positions.
template <int Dim, template <int> typename Source, typename Join>
Error error_of_estimate(Source<Dim> data, const Join& join, Error error) {
  if (error.kind != ErrorKind::kBadInput) return error;
  const std::string source = data.source;
  const bool is_for_positions = give_positions(data) && join(std::move(data));
  const std::string why = is_for_positions
                              ? "observations of ranges or bearings alone leave features free to move as long as --associate "
                                "does not know which are the same: it needs observations that give positions; where ids hold, "
                                "leave it out"
                              : error.message;
  return bad_input_of(source, why).value();
}

/// Identities by `labels` or, if names hold, by names: a name is then one feature within each part.
template <typename Data>
Identities identities_of(const Data& data, const std::vector<NamedSighting>& seen, std::vector<Sighting> sightings,
                         std::vector<std::size_t> labels, const AssociationOptions& options) {
  if (!options.names_hold) return {std::move(sightings), std::move(labels)};
  const PartNumbers parts = part_numbers_of(data);
  labels.clear();
  for (std::size_t s = 0; s < seen.size(); ++s) {
    sightings[s].scan = parts.of_pose[seen[s].base];
    labels.push_back(seen[s].name.position());
  }
  return {std::move(sightings), std::move(labels)};
}

template <typename Data, int Dim>
Associated<Data> associated(const Data& data, const std::vector<NamedSighting>& seen, const IdentitySearch<Dim>& search) {
  Associated<Data> result{renamed(data, search.identities()), {}, search.joins(), search.is_settled(), {}};
  for (std::size_t s = 0; s < seen.size(); ++s) {
    AssociatedSighting& sighting = result.sightings.emplace_back();
    sighting.base = data.poses[seen[s].base];
    sighting.name = data.features[seen[s].name];
    sighting.joined = result.data.features[search.identities().feature_of(s)];
    sighting.gate = std::sqrt(search.gate());
    if (const auto& match = search.matches()[s]) {
      sighting.distance = std::sqrt(match->squared_distance);
      sighting.alternatives = match->candidates - 1;
    }
  }
  for (const PartsApart& pair : search.parts_apart()) {
    const auto first = [&](std::uint32_t part) { return data.poses[search.first_poses()[part]]; };
    result.untied.push_back({first(pair.first), first(pair.second), pair.alignment});
  }
  return result;
}

/// The result of a second search, whose gates are narrow at first, if it has fewer features than the first one: maps laid in a
/// wrong place leave features twice that are seen again. Otherwise the result of the first search, whose gates are wide.
template <int Dim, template <int> typename Source>
Expected<Associated<Source<Dim>>> found_in(const Source<Dim>& data, const Identities& identities,
                                           const std::vector<std::optional<Match>>& matches,
                                           const NeighbourDensity<Dim>& density, const AssociationOptions& options,
                                           const typename IdentitySearch<Dim>::EstimateOf& estimate_of,
                                           const std::vector<NamedSighting>& seen, const std::stop_token& stop) {
  IdentitySearch<Dim> first(identities, matches, density, options, estimate_of, SearchGates::kWide, stop);
  if (auto ran = first.run(); !ran) return tl::unexpected(ran.error());
  const bool has_merged = first.identities().feature_count() < identities.feature_count();
  const bool is_worth_another = options.method != AssociationMethod::kNearest && has_merged && first.is_settled();
  if (!is_worth_another) return associated(data, seen, first);
  AssociationOptions further = options;
  if (options.progress) further.progress = [&](std::size_t joins) { options.progress(first.joins() + joins); };
  IdentitySearch<Dim> second(identities, matches, density, further, estimate_of, SearchGates::kNarrowFirst, stop);
  const auto ran_again = second.run();
  if (!ran_again && ran_again.error().kind == ErrorKind::kInterrupted) return tl::unexpected(ran_again.error());
  const bool is_better = ran_again && second.identities().feature_count() < first.identities().feature_count();
  auto found = associated(data, seen, is_better ? second : first);
  found.joins = first.joins() + second.joins();
  return found;
}

}  // namespace

std::vector<std::string> AssociationOptions::validate() const {
  std::vector<std::string> violations;
  if (!(confidence > 0.0 && confidence < 1.0)) violations.emplace_back("the confidence must be between 0 and 1");
  if (most_joins < 1) violations.emplace_back("the number of joins must be at least 1");
  return violations;
}

template <int Dim>
Expected<Associated<Log<Dim>>> associate(const Log<Dim>& log, const AssociationOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  if (auto sound = check_invariants(log); !sound) return tl::unexpected(sound.error());
  if (!log.feature_priors().empty()) return of_named_prior(log.source);
  NeighbourDensity<Dim> density = density_of<Dim>(log.observations(), {});
  const Split split = split_evenly(log);
  const std::vector<NamedSighting> seen = named_sightings(log);
  std::vector<std::size_t> labels;
  std::vector<std::optional<Match>> matches(seen.size());
  if (!options.names_hold) {
    for (const auto& [feature, match] : track_log(log, split, options, density, stop)) {
      matches[labels.size()] = match;
      labels.push_back(feature);
    }
    if (stop.stop_requested()) return interrupted("associating");
  }
  const auto join = [&](Log<Dim> data) { return estimate_of(std::move(data), split, stop); };
  const auto estimate = [&](const Identities& known) {
    return join(renamed(log, known)).map_error([&](Error error) {
      return error_of_estimate(renamed(log, known), join, std::move(error));
    });
  };
  return found_in(log, identities_of(log, seen, sightings_of(log, split), std::move(labels), options), matches, density,
                  options, estimate, seen, stop);
}

template <int Dim>
Expected<Associated<SubmapSet<Dim>>> associate(const SubmapSet<Dim>& set, const AssociationOptions& options,
                                               const std::stop_token& stop) {
  demand_valid(options);
  if (auto sound = check_content(set).and_then([&] { return check_segments(set); }); !sound) {
    return tl::unexpected(sound.error());
  }
  if (std::ranges::any_of(set.graph.feature_factors, [](const auto& o) { return o.base == kWorld; }))
    return of_named_prior(set.source);
  const NeighbourDensity<Dim> density = density_of<Dim>(set.graph.feature_factors, set.graph.submaps);
  const std::vector<NamedSighting> seen = named_sightings(set);
  std::vector<std::size_t> labels(seen.size());
  std::iota(labels.begin(), labels.end(), std::size_t{0});
  const auto join = [&](SubmapSet<Dim> data) { return estimate_of(std::move(data), stop); };
  const auto estimate = [&](const Identities& known) {
    return join(renamed(set, known)).map_error([&](Error error) {
      return error_of_estimate(renamed(set, known), join, std::move(error));
    });
  };
  return found_in(set, identities_of(set, seen, sightings_of(set), std::move(labels), options),
                  std::vector<std::optional<Match>>(seen.size()), density, options, estimate, seen, stop);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                         \
  template Expected<Associated<Log<Dim>>> associate(const Log<Dim>&, const AssociationOptions&, const std::stop_token&); \
  template Expected<Associated<SubmapSet<Dim>>> associate(const SubmapSet<Dim>&, const AssociationOptions&,              \
                                                          const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
