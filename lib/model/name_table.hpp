// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The ids that a log mentions, each once and in ascending order.

#include <algorithm>
#include <mapjoin/model/ids.hpp>
#include <utility>
#include <vector>

namespace mapjoin {

/// Collects ids as they are mentioned. As long as new ids come in ascending order, as in most logs, none is stored twice.
template <typename Id>
class NameTable {
 public:
  void mention(const Id& id) {
    if (ascending_ && find_ascending(mentions_, id)) return;
    ascending_ = ascending_ && (mentions_.empty() || mentions_.back() < id);
    mentions_.push_back(id);
  }

  /// Adds the mentions of another table, in their order.
  void mention_all(const NameTable& other) {
    for (const Id& id : other.mentions_) mention(id);
  }

  /// Takes out every id once, in ascending order; the table is spent.
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
