// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <mapjoin/join/association/identities.hpp>
#include <mapjoin/model/lists.hpp>
#include <numeric>

namespace mapjoin {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

}  // namespace

Identities::Identities(std::vector<Sighting> sightings, std::vector<std::size_t> labels)
    : sightings_(std::move(sightings)), feature_of_(sightings_.size()), apart_from_(sightings_.size()) {
  std::size_t maps = 0;
  for (const Sighting& s : sightings_) maps = std::max(maps, s.map + 1);
  in_map_.resize(maps);
  number(labels);
}

void Identities::number(const std::vector<std::size_t>& labels) {
  std::vector<std::size_t> numbers(labels.empty() ? 0 : *std::ranges::max_element(labels) + 1, kNone);
  members_.clear();
  scans_.clear();
  for (auto& features : in_map_) features.clear();
  for (std::size_t s = 0; s < labels.size(); ++s) {
    std::size_t& number = numbers[labels[s]];
    if (number == kNone) {
      number = members_.size();
      members_.emplace_back();
      scans_.emplace_back();
    }
    feature_of_[s] = FeatureIndex(number);
    members_[feature_of_[s]].push_back(s);
    auto& scans = scans_[feature_of_[s]];
    if (scans.empty() || scans.back() != sightings_[s].scan) scans.push_back(sightings_[s].scan);
    in_map_[sightings_[s].map].push_back(feature_of_[s]);
  }
  const auto make_set = [](auto& list) { make_distinct(list); };
  std::ranges::for_each(in_map_, make_set);
  std::ranges::for_each(scans_, make_set);
}

bool Identities::may_be_same(FeatureIndex one, FeatureIndex other) const {
  const std::vector<std::size_t>& a = scans_[one];
  const std::vector<std::size_t>& b = scans_[other];
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i == *j) return false;
    ++(*i < *j ? i : j);
  }
  return std::ranges::none_of(members_[one], [&](std::size_t s) {
    return std::ranges::any_of(apart_from_[s], [&](std::size_t t) { return feature_of_[t] == other; });
  });
}

std::vector<std::vector<std::size_t>> Identities::merge(std::span<const std::pair<FeatureIndex, FeatureIndex>> pairs) {
  std::vector<std::vector<std::size_t>> moved(pairs.size());
  std::vector<std::size_t> labels(sightings_.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    // Features merged before in this call are one already: the first sighting of either has its number.
    const FeatureIndex a = feature_of_[members_[pairs[k].first].front()];
    const FeatureIndex b = feature_of_[members_[pairs[k].second].front()];
    if (a == b || !may_be_same(a, b)) continue;
    const FeatureIndex first = std::min(a, b);
    const FeatureIndex second = std::max(a, b);
    moved[k] = members_[second];
    const auto unite = [&](auto& lists) {
      std::vector<std::size_t> both;
      std::ranges::merge(lists[first], lists[second], std::back_inserter(both));
      lists[first] = std::move(both);  // the second keeps its list: its first member leads to the first feature
    };
    unite(members_);
    unite(scans_);
    for (const std::size_t s : members_[first]) feature_of_[s] = first;
  }
  for (std::size_t s = 0; s < labels.size(); ++s) labels[s] = feature_of_[s].position();
  number(labels);
  return moved;
}

void Identities::tell_apart(std::span<const std::size_t> sightings) {
  std::vector<std::size_t> labels(sightings_.size());
  for (std::size_t s = 0; s < labels.size(); ++s) labels[s] = feature_of_[s].position();
  for (const std::size_t own : sightings) labels[own] = members_.size();
  for (const std::size_t own : sightings) {
    for (const std::size_t other : members_[feature_of_[own]]) {
      if (labels[other] == labels[own]) continue;
      apart_from_[own].push_back(other);
      apart_from_[other].push_back(own);
    }
  }
  number(labels);
}

bool Identities::forgive() {
  const bool was_apart = std::ranges::any_of(apart_from_, [](const auto& others) { return !others.empty(); });
  apart_from_.assign(sightings_.size(), {});
  return was_apart;
}

}  // namespace mapjoin
