// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/association/frames/part_ties.hpp>
#include <mapjoin/join/association/joint_placement.hpp>
#include <mapjoin/join/association/map_matching.hpp>
#include <mapjoin/join/association/sighting_fit.hpp>
#include <mapjoin/join/association/tracking.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// Maps are as good as in place where a feature may be mistaken for fewer than one other.
constexpr double kInPlace = 1.0;
/// How much farther maps are looked for, each time that nothing is found nearer, and how often.
constexpr double kFarther = 32.0;
constexpr double kFarthest = 1e6;
/// Observations of a segment, or somewhat more: enough to know its features well, few enough for the odometry between them.
constexpr std::size_t kObservationsPerSegment = 150;

Error interrupted() {
  return {ErrorKind::kInterrupted, "interrupted while associating"};
}

/// Finds identities by joining with those known so far.
template <int Dim, typename EstimateOf>
class Search {
 public:
  Search(Identities identities, std::vector<std::optional<Match>> matches, const NeighbourDensity<Dim>& density,
         const AssociationOptions& options, EstimateOf estimate_of, const std::stop_token& stop)
      : identities_(std::move(identities)),
        density_(density),
        options_(options),
        estimate_of_(std::move(estimate_of)),
        stop_(stop),
        gate_(Matcher<Dim>(density, options.method, options.confidence, sightings()).gate()),
        matches_(std::move(matches)) {}

  Expected<void> run() {
    while (!is_settled_ && joins_ < options_.most_joins) {
      ++joins_;
      auto estimate = estimate_of_(identities_);
      if (!estimate) return tl::unexpected(estimate.error());
      if (options_.progress) options_.progress(joins_);
      const std::vector<SightingTest> tests = tests_of(*estimate, identities_);
      estimate->scale = scale_of(tests, Dim);
      const bool has_changed = undo(misfits(tests, gate_ * estimate->scale)) || extend(*estimate);
      if (stop_.stop_requested()) return tl::unexpected(interrupted());
      if (has_changed || forgive()) continue;
      parts_apart_.clear();
      const auto is_tied = estimate->parts.first_poses.size() > 1 ? tie_parts(*estimate) : Expected<bool>(false);
      if (!is_tied) return tl::unexpected(is_tied.error());
      is_settled_ = !*is_tied;
    }
    return {};
  }

  const Identities& identities() const { return identities_; }
  /// By sighting, how it was last found to be of its feature.
  const std::vector<std::optional<Match>>& matches() const { return matches_; }
  std::size_t joins() const { return joins_; }
  bool is_settled() const { return is_settled_; }
  /// The parts that are left, where nothing ties all together: their first poses, and why each pair stays apart.
  const std::vector<PoseIndex>& first_poses() const { return first_poses_; }
  const std::vector<PartsApart>& parts_apart() const { return parts_apart_; }
  double gate() const { return gate_; }

 private:
  double sightings() const { return static_cast<double>(identities_.sighting_count()); }

  /// Gives what was told apart a second chance, once: the map may have been bent when it was.
  bool forgive() { return !std::exchange(has_forgiven_, true) && identities_.forgive(); }

  bool undo(const std::vector<SightingTest>& misfits) {
    for (const SightingTest& misfit : misfits) {
      // Numbers change with each feature that is told apart, sightings do not.
      if (auto sightings = taken_with(misfit); !sightings.empty()) apart_.push_back(std::move(sightings));
    }
    const bool has_changed = !apart_.empty();
    for (const auto& sightings : apart_) {
      identities_.tell_apart(sightings);
      for (const std::size_t s : sightings) matches_[s].reset();
    }
    apart_.clear();
    return has_changed;
  }

  /// The sightings of a feature that a map has of it or, where names hold, the part that the map is of: none where all are.
  std::vector<std::size_t> taken_with(const SightingTest& misfit) const {
    const auto all = identities_.sightings_of(misfit.feature);
    const auto of_map = [&](std::size_t s) { return identities_.sighting(s).map == misfit.map; };
    const std::size_t scan = identities_.sighting(*std::ranges::find_if(all, of_map)).scan;
    std::vector<std::size_t> taken;
    std::ranges::copy_if(all, std::back_inserter(taken),
                         [&](std::size_t s) { return options_.names_hold ? identities_.sighting(s).scan == scan : of_map(s); });
    if (taken.size() == all.size()) taken.clear();
    return taken;
  }

  /// Takes what is probable: of maps that are in place all of it, else of the pair of maps that is the surest.
  bool extend(const FeatureEstimate<Dim>& estimate) {
    const MapMatching<Dim> matching(estimate, identities_, density_, options_.method, options_.confidence);
    const bool is_first = joins_ == 1;
    if (take(matching.propose(kInPlace, is_first, stop_).probable) || is_first) return true;  // then all maps are matched
    if (options_.method == AssociationMethod::kNearest) return false;
    return place_together(estimate, matching) || take_surest(matching);
  }

  /// Takes what is probable of maps that could lie on each other in several ways, all of them together.
  bool place_together(const FeatureEstimate<Dim>& estimate, const MapMatching<Dim>& matching) {
    JointPlacement<Dim> placement(estimate, identities_, density_, options_.confidence, matching.pairs(kFarther, stop_));
    return take(placement.propose(stop_));
  }

  /// Takes what is probable of the surest pair of maps that are not in place.
  bool take_surest(const MapMatching<Dim>& matching) {
    for (double reach = kFarther; reach < kFarthest; reach *= kFarther) {
      auto [probable, beyond_reach] = matching.propose(reach, false, stop_);
      if (stop_.stop_requested()) return false;
      const auto surest = std::ranges::max_element(probable, {}, [](const Proposal& p) { return p.match.score; });
      if (surest != probable.end()) {
        const auto maps = std::pair(surest->maps[0], surest->maps[1]);
        std::erase_if(probable, [&](const Proposal& p) { return std::pair(p.maps[0], p.maps[1]) != maps; });
        if (take(std::move(probable))) return true;
      }
      if (beyond_reach == 0) break;
    }
    return false;
  }

  /// Aligns parts that nothing ties by constellations of their features.
  Expected<bool> tie_parts(const FeatureEstimate<Dim>& estimate) {
    auto found = ties_between_parts(estimate, identities_, density_, options_.confidence, stop_);
    if (!found) return tl::unexpected(found.error());
    first_poses_ = estimate.parts.first_poses;
    parts_apart_ = std::move(found->apart);
    const auto moved = identities_.merge(found->ties);
    return std::ranges::any_of(moved, [](const auto& sightings) { return !sightings.empty(); });
  }

  bool take(std::vector<Proposal> proposals) {
    std::ranges::stable_sort(proposals, std::greater<>(), [](const Proposal& p) { return p.match.probability; });
    std::vector<std::pair<FeatureIndex, FeatureIndex>> pairs;
    for (const Proposal& p : proposals) pairs.emplace_back(p.one, p.other);
    const auto moved = identities_.merge(pairs);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      for (const std::size_t s : moved[k]) matches_[s] = proposals[k].match;
    }
    return std::ranges::any_of(moved, [](const auto& sightings) { return !sightings.empty(); });
  }

  Identities identities_;
  const NeighbourDensity<Dim>& density_;
  const AssociationOptions& options_;
  EstimateOf estimate_of_;
  const std::stop_token& stop_;
  double gate_;
  std::vector<std::optional<Match>> matches_;
  std::size_t joins_ = 0;
  bool has_forgiven_ = false;
  bool is_settled_ = false;
  std::vector<PoseIndex> first_poses_;
  std::vector<PartsApart> parts_apart_;
  std::vector<std::vector<std::size_t>> apart_;  // sightings that are told apart
};

/// The points that every pose or local map sees at once.
template <int Dim>
std::vector<std::vector<Point<Dim>>> seen_at_once(std::span<const FeatureFactor<Dim>> observations,
                                                  const std::vector<LocalMap<Dim>>& maps) {
  std::vector<std::vector<Point<Dim>>> sets;
  for (const auto& map : maps) sets.push_back(map.feature_estimates);
  PoseIndex pose = kWorld;
  for (const auto& observation : observations) {
    if (std::exchange(pose, observation.base) != observation.base) sets.emplace_back();
    sets.back().push_back(observation.measured);
  }
  return sets;
}

/// So many poses a segment that it has about kObservationsPerSegment.
template <int Dim>
Split split_evenly(const Log<Dim>& log) {
  const std::size_t observations = std::max<std::size_t>(1, log.observations().size());
  const std::size_t poses = 1 + kObservationsPerSegment * log.poses.size() / observations;
  return split(log, {SplitRule::kPoses, static_cast<double>(std::max<std::size_t>(2, poses))});
}

/// All observations, segment by segment; their features are numbered through.
template <int Dim>
std::vector<Tracked> tracked(const Log<Dim>& log, const Split& split, const NeighbourDensity<Dim>& density,
                             const AssociationOptions& options, const std::stop_token& stop) {
  std::vector<std::vector<Tracked>> of_segments(split.segments.size());
  parallel_for(of_segments.size(), [&](std::size_t k) {
    if (stop.stop_requested()) return;
    Matcher<Dim> matcher(density, options.method, options.confidence, static_cast<double>(log.observations().size()));
    of_segments[k] = track(segment_view(log, split, split.segments[k]), matcher, options.confidence);
  });
  std::vector<Tracked> all;
  std::size_t first = 0;
  for (const auto& some : of_segments) {
    std::size_t next = first;
    for (const auto& [feature, match] : some) {
      all.push_back({first + feature, match});
      next = std::max(next, first + feature + 1);
    }
    first = next;
  }
  return all;
}

/// The base and the name of a sighting.
struct Seen {
  PoseIndex base;
  FeatureIndex name;
};

/// Sightings by their labels or, where names hold, by these: whatever hangs together has one feature under one name.
template <typename Data>
Identities identities_of(const Data& data, const std::vector<Seen>& seen, std::vector<Sighting> sightings,
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

template <typename Data, typename Search>
Associated<Data> associated(const Data& data, const std::vector<Seen>& seen, const Search& search) {
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

template <int Dim, template <int> typename Source, typename EstimateOf>
Expected<Associated<Source<Dim>>> found_in(const Source<Dim>& data, Identities identities,
                                           std::vector<std::optional<Match>> matches, const NeighbourDensity<Dim>& density,
                                           const AssociationOptions& options, const EstimateOf& estimate_of,
                                           const std::vector<Seen>& seen, const std::stop_token& stop) {
  Search<Dim, EstimateOf> search(std::move(identities), std::move(matches), density, options, estimate_of, stop);
  return search.run().map([&] { return associated(data, seen, search); });
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
  if (!log.feature_priors().empty()) {
    return bad_input(log.source + ": has a prior of a feature, which goes by its name, and names are ignored by --associate");
  }
  const auto sets = seen_at_once<Dim>(log.observations(), {});
  const NeighbourDensity<Dim> density(sets);
  const Split split = split_evenly(log);
  std::vector<Seen> seen;
  for (const auto& observation : log.observations()) seen.push_back({observation.base, observation.target});
  std::vector<std::size_t> labels;
  std::vector<std::optional<Match>> matches(seen.size());
  if (!options.names_hold) {
    for (const auto& [feature, match] : tracked(log, split, density, options, stop)) {
      matches[labels.size()] = match;
      labels.push_back(feature);
    }
    if (stop.stop_requested()) return tl::unexpected(interrupted());
  }
  const auto estimate = [&](const Identities& known) { return estimate_of(renamed(log, known), split, stop); };
  return found_in(log, identities_of(log, seen, sightings_of(log, split), std::move(labels), options), std::move(matches),
                  density, options, estimate, seen, stop);
}

template <int Dim>
Expected<Associated<SubmapSet<Dim>>> associate(const SubmapSet<Dim>& set, const AssociationOptions& options,
                                               const std::stop_token& stop) {
  demand_valid(options);
  const auto sets = seen_at_once<Dim>(set.graph.feature_factors, set.graph.submaps);
  const NeighbourDensity<Dim> density(sets);
  std::vector<Seen> seen;
  for (const auto& map : set.graph.submaps) {
    for (const FeatureIndex feature : map.features) seen.push_back({map.base, feature});
  }
  for (const auto& observation : set.graph.feature_factors) seen.push_back({observation.base, observation.target});
  std::vector<std::size_t> labels(seen.size());
  std::iota(labels.begin(), labels.end(), std::size_t{0});
  const auto estimate = [&](const Identities& known) { return estimate_of(renamed(set, known), stop); };
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
