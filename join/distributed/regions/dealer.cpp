// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/distributed/regions/dealer.hpp>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/model/renumber.hpp>
#include <utility>

namespace mapjoin::distributed {

template <int Dim>
std::string encoded(const Dealt<Dim>& d) {
  return Writer()
      .put(d.pose_factors)
      .put(d.feature_factors)
      .put(d.poses)
      .put(d.pose_values)
      .put(d.features)
      .put(d.feature_values)
      .bytes();
}

template <int Dim>
Dealt<Dim> decoded(const std::string& message) {
  Reader reader(message);
  Dealt<Dim> dealt;
  dealt.pose_factors = reader.take<PoseFactor<Dim>>();
  dealt.feature_factors = reader.take<FeatureFactor<Dim>>();
  dealt.poses = reader.take<PoseIndex>();
  dealt.pose_values = reader.take<Pose<Dim>>();
  dealt.features = reader.take<FeatureIndex>();
  dealt.feature_values = reader.take<Point<Dim>>();
  return dealt;
}

template <int Dim>
Dealer<Dim>::Dealer(const Table<PoseIndex, std::int32_t>& regions, std::size_t per_rank, const LogShare<Dim>& share,
                    const Values<Dim>& values)
    : regions_(regions),
      per_rank_(per_rank),
      share_(share),
      values_(values),
      place_of_(share.poses),
      degrees_(regions.size(), 0) {
  Table<PoseIndex, bool> is_told(share.poses.size());
  for (const auto& o : share.log.edges()) {
    for (const PoseIndex p : {o.base, o.target}) {
      is_told[p] = true;
      ++degrees_[share.poses[p]];
    }
  }
  for (const auto& o : share.log.observations()) is_told[o.base] = true;
  for (const auto& o : share.apart.pose_factors) {
    is_told[own_place(o)] = true;
    if (o.base == kWorld) continue;
    ++degrees_[o.base];
    ++degrees_[o.target];
  }
  for (const PoseIndex p : indices(is_told)) {
    if (!is_told[p]) told_by_none_.push_back(p);
  }
}

template <int Dim>
std::vector<std::string> Dealer<Dim>::messages(std::size_t k, std::size_t ranks) {
  turn_ = k;
  hands_.assign(ranks, {{}, Table<PoseIndex, bool>(share_.poses.size()), Table<FeatureIndex, bool>(share_.features.size())});
  const auto& poses = share_.poses;
  for (const auto& o : share_.log.edges()) deal(o, home_of(poses[o.base], poses[o.target]), &Dealt<Dim>::pose_factors);
  for (const auto& o : share_.log.observations()) deal(o, poses[o.base], &Dealt<Dim>::feature_factors);
  for (const auto& o : share_.apart.pose_factors) deal_apart(o);
  for (const PoseIndex p : told_by_none_) {
    for (Hand& hand : hands_) give(p, hand);
  }
  if (turn_ == 0) append(hands_.front().dealt.feature_factors, share_.apart.feature_factors);
  std::vector<std::string> messages;
  for (Hand& hand : hands_) messages.push_back(encoded(std::exchange(hand, {}).dealt));
  return messages;
}

template <int Dim>
typename Dealer<Dim>::Hand* Dealer<Dim>::hand_of(PoseIndex pose) {
  const auto region = static_cast<std::size_t>(regions_[pose]);
  return region % per_rank_ == turn_ ? &hands_[region / per_rank_] : nullptr;
}

template <int Dim>
PoseIndex Dealer<Dim>::home_of(PoseIndex base, PoseIndex target) const {
  return degrees_[target] < degrees_[base] ? target : base;
}

template <int Dim>
template <typename Factor>
void Dealer<Dim>::deal(Factor o, PoseIndex home, std::vector<Factor> Dealt<Dim>::*factors) {
  Hand* hand = hand_of(home);
  if (!hand) return;
  give(o.base, *hand);
  give(o.target, *hand);
  renumber(o, [&](auto place) { return index_in(share_, place); });
  (hand->dealt.*factors).push_back(o);
}

template <int Dim>
PoseIndex Dealer<Dim>::own_place(const PoseFactor<Dim>& o) const {
  return place_of_(o.base == kWorld ? o.target : std::min(o.base, o.target)).value();
}

template <int Dim>
void Dealer<Dim>::deal_apart(const PoseFactor<Dim>& o) {
  Hand* hand = hand_of(o.base == kWorld ? o.target : home_of(o.base, o.target));
  if (!hand) return;
  hand->dealt.pose_factors.push_back(o);
  give(own_place(o), *hand);
}

template <int Dim>
void Dealer<Dim>::give(PoseIndex p, Hand& hand) const {
  if (hand.has_pose[p]) return;
  hand.has_pose[p] = true;
  hand.dealt.poses.push_back(share_.poses[p]);
  hand.dealt.pose_values.push_back(values_.poses[p]);
}

template <int Dim>
void Dealer<Dim>::give(FeatureIndex f, Hand& hand) const {
  if (hand.has_feature[f]) return;
  hand.has_feature[f] = true;
  hand.dealt.features.push_back(share_.features[f]);
  hand.dealt.feature_values.push_back(values_.features[f]);
}

#define MAPJOIN_INSTANTIATE(Dim)                   \
  template std::string encoded(const Dealt<Dim>&); \
  template Dealt<Dim> decoded(const std::string&); \
  template class Dealer<Dim>;
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::distributed
