// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <mapjoin/graph/connectivity.hpp>
#include <vector>

namespace mapjoin {
namespace {

/// At most this many components are named.
constexpr std::size_t kNamed = 3;

/// Disjoint sets over the World (vertex 0), poses and features.
class Components {
 public:
  Components(std::size_t poses, std::size_t features)
      : poses_(poses),
        parent_(1 + poses + features),
        rank_(parent_.size()),
        is_tied_(parent_.size(), false),
        sets_(rank_.data(), parent_.data()) {
    for (std::size_t v = 0; v < parent_.size(); ++v) sets_.make_set(v);
  }

  std::size_t pose(Index index) const { return static_cast<std::size_t>(index + 1); }  // kWorld is vertex 0
  std::size_t feature(Index index) const { return 1 + poses_ + static_cast<std::size_t>(index); }

  void tie(std::size_t a, std::size_t b) {
    sets_.union_set(a, b);
    is_tied_[a] = is_tied_[b] = true;
  }
  bool is_tied(std::size_t v) const { return is_tied_[v]; }

  /// A vertex of each component; the World counts only where something hangs on it.
  std::vector<std::size_t> roots() {
    std::vector<std::size_t> first_of(parent_.size(), parent_.size());
    std::vector<std::size_t> firsts;
    for (std::size_t v = is_tied_[0] ? 0 : 1; v < parent_.size(); ++v) {
      std::size_t& first = first_of[sets_.find_set(v)];
      if (first != parent_.size()) continue;
      first = v;
      firsts.push_back(v);
    }
    return firsts;
  }

 private:
  std::size_t poses_;
  std::vector<std::size_t> parent_;
  std::vector<std::size_t> rank_;
  std::vector<bool> is_tied_;
  boost::disjoint_sets<std::size_t*, std::size_t*> sets_;
};

Expected<void> check(Components& components, const std::string& source, const std::vector<PoseId>& poses,
                     const std::vector<FeatureId>& features) {
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (!components.is_tied(components.feature(static_cast<Index>(f)))) {
      return bad_input(fmt::format("{}: {} is never observed", source, to_string(features[f])));
    }
  }
  const auto roots = components.roots();
  if (roots.size() <= 1) return {};
  std::string names;
  for (std::size_t k = 0; k < std::min(roots.size(), kNamed); ++k) {
    const std::size_t v = roots[k];
    if (k > 0) names += ", ";
    names += v == 0 ? "the World" : v <= poses.size() ? to_string(poses[v - 1]) : to_string(features[v - 1 - poses.size()]);
  }
  return bad_input(fmt::format("{}: nothing ties its {} parts together; they hold {}{}", source, roots.size(), names,
                               roots.size() > kNamed ? ", …" : ""));
}

}  // namespace

template <int Dim>
Expected<void> check_connected(const Log<Dim>& log) {
  Components components(log.poses.size(), log.features.size());
  for (const auto* list : {&log.odometry, &log.closures, &log.pose_priors}) {
    for (const auto& o : *list) components.tie(components.pose(o.base), components.pose(o.target));
  }
  for (const auto* list : {&log.observations, &log.feature_priors}) {
    for (const auto& o : *list) components.tie(components.pose(o.base), components.feature(o.target));
  }
  for (const auto& fixed : log.fixed) components.tie(components.pose(kWorld), components.pose(fixed.pose));
  return check(components, log.source, log.poses, log.features);
}

template <int Dim>
Expected<void> check_connected(const MapSet<Dim>& set) {
  Components components(set.poses.size(), set.features.size());
  for (const auto& map : set.maps) {
    for (const Index pose : map.poses) components.tie(components.pose(map.base), components.pose(pose));
    for (const Index feature : map.features) components.tie(components.pose(map.base), components.feature(feature));
  }
  for (const auto& o : set.pose_observations) components.tie(components.pose(o.base), components.pose(o.target));
  for (const auto& o : set.feature_observations) components.tie(components.pose(o.base), components.feature(o.target));
  for (const auto& fixed : set.fixed) components.tie(components.pose(kWorld), components.pose(fixed.pose));
  return check(components, set.source, set.poses, set.features);
}

template Expected<void> check_connected(const Log<2>&);
template Expected<void> check_connected(const Log<3>&);
template Expected<void> check_connected(const MapSet<2>&);
template Expected<void> check_connected(const MapSet<3>&);

}  // namespace mapjoin
