// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The ids that a log mentions, each once and in ascending order, and the index that each stands at.

#include <algorithm>
#include <mapjoin/model/ids.hpp>
#include <utility>
#include <vector>

namespace mapjoin {

/// Where `id` stands, or would stand, among the ascending `names`. Constant time where keys are consecutive.
template <typename Id>
std::size_t position_of(const std::vector<Id>& names, const Id& id) {
  const std::uint64_t guess = names.empty() ? 0 : id.key - names.front().key;
  if (guess < names.size() && names[guess] == id) return guess;
  return static_cast<std::size_t>(std::lower_bound(names.begin(), names.end(), id) - names.begin());
}

template <typename Id>
bool contains(const std::vector<Id>& names, const Id& id) {
  const std::size_t i = position_of(names, id);
  return i < names.size() && names[i] == id;
}

/// Collects mentions. As long as new ids come in ascending order, as they do in most logs, none is kept twice.
template <typename Id>
class NameTable {
 public:
  void mention(const Id& id) {
    if (ascending_ && contains(mentions_, id)) return;
    ascending_ = ascending_ && (mentions_.empty() || mentions_.back() < id);
    mentions_.push_back(id);
  }

  /// Every id once, in ascending order; the table is spent.
  std::vector<Id> take() {
    if (!ascending_) {
      std::sort(mentions_.begin(), mentions_.end());
      mentions_.erase(std::unique(mentions_.begin(), mentions_.end()), mentions_.end());
    }
    mentions_.shrink_to_fit();
    return std::move(mentions_);
  }

 private:
  std::vector<Id> mentions_;
  bool ascending_ = true;
};

}  // namespace mapjoin
