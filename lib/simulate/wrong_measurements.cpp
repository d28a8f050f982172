// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/simulate/random_stream.hpp>
#include <mapjoin/simulate/wrong_measurements.hpp>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace mapjoin {
namespace {

/// The random streams, one for each purpose: a change of one leaves the others alone.
enum PlantingStream : std::uint64_t { kEnds, kRelativePoses, kInformations, kIdentities };

constexpr std::size_t kGroup = 20;
constexpr std::size_t kMostStepsLocally = 20;
constexpr double kTranslationSigma = 0.3;                         // (m)
constexpr double kRotationSigma = 10.0 * std::numbers::pi / 180;  // (rad)

/// The poses that the first closure of a group ties together, at least two steps apart, since otherwise it would be odometry;
/// `starts` is the number of poses that a group can start from.
std::pair<PoseIndex, PoseIndex> draw_ends(RandomStream& random, std::size_t starts, bool is_local) {
  while (true) {
    const std::size_t a = random.next() % starts;
    const std::size_t reach = std::min(kMostStepsLocally + 1, starts - a);
    const std::size_t b = is_local ? a + random.next() % reach : random.next() % starts;
    if (a == b) continue;
    const auto [first, second] = std::minmax(a, b);
    return {PoseIndex(first), PoseIndex(std::max(second, first + 2))};
  }
}

template <int Dim>
Pose<Dim> draw_near_identity(RandomStream& random) {
  PoseVector<Dim> step;
  for (int axis = 0; axis < kPoseDof<Dim>; ++axis) {
    step[axis] = (axis < Dim ? kTranslationSigma : kRotationSigma) * random.normal();
  }
  return retract(Pose<Dim>{}, step);
}

/// A random feature other than the one given.
class OtherName {
 public:
  OtherName(std::size_t features, RandomStream& random) : features_(features), random_(random) {
    if (features < 2) throw std::invalid_argument("no other feature whose name an observation could be given");
  }
  FeatureIndex operator()(FeatureIndex own) const {
    return FeatureIndex((own.position() + 1 + random_.next() % (features_ - 1)) % features_);
  }

 private:
  std::size_t features_;
  RandomStream& random_;
};

}  // namespace

template <int Dim>
Planted<Dim> plant_wrong_closures(const Log<Dim>& log, ClosurePolicy policy, std::size_t count, std::uint64_t seed) {
  const bool is_local = policy == ClosurePolicy::kLocal || policy == ClosurePolicy::kLocalGroups;
  const bool in_groups = policy == ClosurePolicy::kRandomGroups || policy == ClosurePolicy::kLocalGroups;
  const std::size_t group = in_groups ? kGroup : 1;
  const auto models = log.closures().empty() ? log.edges() : log.closures();
  if (log.poses.size() < group + 2) throw std::invalid_argument("too few poses for wrong closures");
  if (models.empty()) throw std::invalid_argument("no edge whose information wrong closures could have");

  RandomStream ends(seed, kEnds);
  RandomStream relative_poses(seed, kRelativePoses);
  RandomStream informations(seed, kInformations);
  Planted<Dim> planted{log, std::vector<bool>(log.closures().size())};
  for (std::size_t made = 0; made < count;) {
    auto [base, target] = draw_ends(ends, log.poses.size() - group, is_local);
    const Pose<Dim> measured = draw_near_identity<Dim>(relative_poses);
    for (const std::size_t end = std::min(count, made + group); made < end; ++made) {
      const PoseMatrix<Dim>& information = models[informations.next() % models.size()].information;
      planted.log.graph.pose_factors.push_back({base++, target++, measured, information});
    }
  }
  planted.is_wrong.resize(planted.is_wrong.size() + count, true);
  put_in_order(planted.log);
  return planted;
}

template <int Dim>
Planted<Dim> plant_wrong_identities(const Log<Dim>& log, double share, std::uint64_t seed) {
  RandomStream random(seed, kIdentities);
  const OtherName other_name(log.features.size(), random);
  Planted<Dim> planted{log, std::vector<bool>(log.observations().size())};
  for (std::size_t k = 0; k < planted.is_wrong.size(); ++k) {
    if (random.uniform(0.0, 1.0) >= share) continue;
    FeatureIndex& target = planted.log.graph.feature_factors[k].target;
    target = other_name(target);
    planted.is_wrong[k] = true;
  }
  return planted;
}

template <int Dim>
PlantedSet<Dim> plant_wrong_identities(const SubmapSet<Dim>& set, double share, std::uint64_t seed) {
  RandomStream random(seed, kIdentities);
  const OtherName other_name(set.features.size(), random);
  PlantedSet<Dim> planted{set, {}};
  Table<FeatureIndex, int> maps(set.features.size());  // number of maps that have each feature
  for (const auto& map : set.graph.submaps) {
    for (const FeatureIndex f : map.features) ++maps[f];
  }
  for (auto& map : planted.set.graph.submaps) {
    std::vector<bool>& is_wrong = planted.is_wrong.emplace_back(map.features.size());
    for (std::size_t k = 0; k < is_wrong.size(); ++k) {
      if (random.uniform(0.0, 1.0) >= share) continue;
      const FeatureIndex other = other_name(map.features[k]);
      if (maps[map.features[k]] == 1 || std::ranges::find(map.features, other) != map.features.end()) continue;
      --maps[map.features[k]];
      ++maps[other];
      map.features[k] = other;
      is_wrong[k] = true;
    }
  }
  return planted;
}

template Planted<2> plant_wrong_closures(const Log<2>&, ClosurePolicy, std::size_t, std::uint64_t);
template Planted<3> plant_wrong_closures(const Log<3>&, ClosurePolicy, std::size_t, std::uint64_t);
template Planted<2> plant_wrong_identities(const Log<2>&, double, std::uint64_t);
template Planted<3> plant_wrong_identities(const Log<3>&, double, std::uint64_t);
template PlantedSet<2> plant_wrong_identities(const SubmapSet<2>&, double, std::uint64_t);
template PlantedSet<3> plant_wrong_identities(const SubmapSet<3>&, double, std::uint64_t);

}  // namespace mapjoin
