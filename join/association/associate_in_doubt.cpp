// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/association/associate_in_doubt.hpp>
#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/robust/selection.hpp>
#include <mapjoin/join/robust/support/closure_support.hpp>
#include <utility>
#include <variant>
#include <vector>

namespace mapjoin {
namespace {

/// The most times that features are found, each time with the closures that fit those found before.
constexpr int kMostRounds = 3;

/// The inliers of data that may be in parts.
template <typename Data>
Expected<Inliers<Data>> inliers_of(const Data& data, const RobustOptions& robust, const std::stop_token& stop) {
  Data held = data;
  hold_parts(held);
  return find_inliers(held, robust, stop).map([&](Inliers<Data> inliers) {
    inliers.input.graph.fixed = data.graph.fixed;
    return inliers;
  });
}

/// The associations of all sightings of `data`, found by some of them, at least one of each name. The others have no match.
template <typename Data>
Associated<Data> of_all_sightings(const Data& data, const std::vector<NamedSighting>& some, Associated<Data> found) {
  Table<FeatureIndex, std::size_t> joined(data.features.size());
  for (std::size_t s = 0; s < some.size(); ++s) joined[some[s].name] = found.sightings[s].joined.key;
  const std::vector<NamedSighting> all = named_sightings(data);
  std::vector<std::size_t> labels;
  for (const NamedSighting& one : all) labels.push_back(joined[one.name]);
  const Identities identities(std::vector<Sighting>(all.size()), std::move(labels));
  found.data = renamed(data, identities);

  std::vector<AssociatedSighting> sightings;
  std::size_t next = 0;  // of `some`
  for (std::size_t s = 0; s < all.size(); ++s) {
    AssociatedSighting& sighting = sightings.emplace_back();
    const bool took_part = next < some.size() && some[next].base == all[s].base && some[next].name == all[s].name;
    if (took_part) sighting = found.sightings[next++];
    sighting.base = data.poses[all[s].base];
    sighting.name = data.features[all[s].name];
    sighting.joined = found.data.features[identities.feature_of(s)];
    sighting.gate = found.sightings.front().gate;
  }
  found.sightings = std::move(sightings);
  return found;
}

/// Associates the parts of data in which names hold.
template <typename Data>
Expected<Associated<Data>> associate_parts(const Data& data, const AssociationOptions& options, const RobustOptions& robust,
                                           const std::stop_token& stop) {
  if (part_numbers_of(data).first_poses.size() == 1) return associate(data, options, stop);
  return inliers_of(data, robust, stop).and_then([&](const Inliers<Data>& inliers) {
    return associate(inliers.input, options, stop).map([&](Associated<Data> found) {
      return of_all_sightings(data, named_sightings(inliers.input), std::move(found));
    });
  });
}

/// An account of a log: its features, and what find_inliers() keeps by them.
template <int Dim>
struct Account {
  Associated<Log<Dim>> found;
  Inliers<Log<Dim>> inliers;

  /// The number of things to be believed: that a feature is there, that a measurement is wrong.
  std::size_t assumptions() const { return found.data.features.size() + inliers.rejected.size(); }
};

/// True if a log has all edges of another one, both in the order of a third.
template <int Dim>
bool has_edges_of(const Log<Dim>& other, const Log<Dim>& log) {
  auto next = log.graph.pose_factors.begin();
  return std::ranges::all_of(other.graph.pose_factors, [&](const PoseFactor<Dim>& edge) {
    next = std::find(next, log.graph.pose_factors.end(), edge);
    return next != log.graph.pose_factors.end();
  });
}

/// The log without features.
template <int Dim>
Log<Dim> without_observations(Log<Dim> log) {
  log.graph.feature_factors.clear();
  log.features.clear();
  log.initial.features.clear();
  return log;
}

/// The log without the odometry that closures, by themselves, contradict.
template <int Dim>
Expected<Log<Dim>> without_doubted_odometry(Log<Dim> log, const RobustOptions& robust, const std::stop_token& stop) {
  return inliers_of(without_observations(log), robust, stop).map([&](const Inliers<Log<Dim>>& inliers) {
    for (const Rejected& one : inliers.rejected) {
      if (one.misfit.kind != PartKind::kOdometry) continue;
      const auto ends = std::minmax(one.misfit.from, std::get<PoseIndex>(one.misfit.to));
      std::erase_if(log.graph.pose_factors, [&](const auto& edge) { return std::minmax(edge.base, edge.target) == ends; });
    }
    put_in_order(log);
    return std::move(log);
  });
}

/// The search for the features of a log whose closures may be wrong.
template <int Dim>
class DoubtedClosures {
 public:
  /// `believed` is the log without what is doubted from the beginning.
  DoubtedClosures(const Log<Dim>& log, const Log<Dim>& believed, const AssociationOptions& options, const RobustOptions& robust,
                  const std::stop_token& stop)
      : log_(log),
        believed_(believed),
        options_(options),
        robust_(robust),
        stop_(stop),
        odds_(supported(OdometryChain<Dim>(believed), believed.closures(), stop).odds) {}

  /// The account that begins without closures. If it does not keep all those that others support, it or the one that begins
  /// with these, whichever has fewer assumptions.
  Expected<Associated<Log<Dim>>> best_account() const {
    auto best = account_from(with_closures(std::vector<bool>(odds_.size())));
    if (stop_.stop_requested()) return interrupted("associating");
    const Log<Dim> with_supported = with_closures(are_supported());
    if (!best || !has_edges_of(with_supported, best->inliers.input)) {
      auto other = account_from(with_supported);
      if (!best || (other && other->assumptions() < best->assumptions())) best = std::move(other);
    }
    return std::move(best).map([](Account<Dim> account) { return std::move(account.found); });
  }

 private:
  std::vector<bool> are_supported() const {
    std::vector<bool> are;
    for (const double odds : odds_) are.push_back(odds > kLeastOdds);
    return are;
  }

  /// What is believed, with only the closures of these flags and, where they leave poses in parts, the likeliest others.
  Log<Dim> with_closures(const std::vector<bool>& are_wanted) const {
    return selected(believed_, tied_together(without_observations(believed_), odds_, are_wanted), {});
  }

  /// Finds features by `believed`, the log without some of its edges, then by the edges that fit the features found.
  Expected<Account<Dim>> account_from(Log<Dim> believed) const {
    std::size_t joins = 0;
    for (int round = 1;; ++round) {
      auto found = associate(believed, options_, stop_);
      if (!found) return tl::unexpected(found.error());
      found->joins = joins += found->joins;
      found->data.graph.pose_factors = log_.graph.pose_factors;
      put_in_order(found->data);
      auto inliers = inliers_of(found->data, robust_, stop_);
      if (!inliers) return tl::unexpected(inliers.error());
      const auto& kept = inliers->input.graph.pose_factors;
      if (round == kMostRounds || kept == believed.graph.pose_factors)
        return Account<Dim>{*std::move(found), *std::move(inliers)};
      believed.graph.pose_factors = kept;
      put_in_order(believed);
    }
  }

  const Log<Dim>& log_;
  const Log<Dim>& believed_;
  const AssociationOptions& options_;
  const RobustOptions& robust_;
  const std::stop_token& stop_;
  std::vector<double> odds_;  // log-odds of each closure, by the others
};

}  // namespace

template <int Dim>
Expected<Associated<Log<Dim>>> associate_in_doubt(const Log<Dim>& log, const AssociationOptions& options,
                                                  const RobustOptions& robust, const std::stop_token& stop) {
  demand_valid(options);
  demand_valid(robust);
  if (auto sound = check_invariants(log); !sound) return tl::unexpected(sound.error());
  if (options.names_hold) return associate_parts(log, options, robust, stop);
  if (log.closures().empty()) return associate(log, options, stop);
  const auto found_by = [&](const Log<Dim>& believed) {
    return DoubtedClosures<Dim>(log, believed, options, robust, stop).best_account();
  };
  return robust.odometry ? without_doubted_odometry(log, robust, stop).and_then(found_by) : found_by(log);
}

template <int Dim>
Expected<Associated<SubmapSet<Dim>>> associate_in_doubt(const SubmapSet<Dim>& set, const AssociationOptions& options,
                                                        const RobustOptions& robust, const std::stop_token& stop) {
  demand_valid(options);
  demand_valid(robust);
  if (auto sound = check_content(set); !sound) return tl::unexpected(sound.error());
  return options.names_hold ? associate_parts(set, options, robust, stop) : associate(set, options, stop);
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
