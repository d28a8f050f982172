// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The ids that a g2o file declares by vertices, and where, to name repeated and missing ones.

#include <algorithm>
#include <cstdint>
#include <mapjoin/io/files/text_scanner.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

class G2oDeclarations {
 public:
  struct Item {
    std::uint64_t key;
    Place place;
  };

  void add(std::uint64_t key, const Place& place) { items_.push_back({key, place}); }
  std::size_t size() const { return items_.size(); }

  /// To be called before contains() and repetition().
  void sort() {
    const auto less = [](const Item& a, const Item& b) { return a.key < b.key; };
    if (!std::is_sorted(items_.begin(), items_.end(), less)) std::stable_sort(items_.begin(), items_.end(), less);
  }
  bool contains(std::uint64_t key) const {
    const auto less = [](const Item& item, std::uint64_t k) { return item.key < k; };
    const auto item = std::lower_bound(items_.begin(), items_.end(), key, less);
    return item != items_.end() && item->key == key;
  }
  /// Where an id is declared for the second time.
  std::optional<Item> repetition() const {
    const auto same = [](const Item& a, const Item& b) { return a.key == b.key; };
    const auto first = std::adjacent_find(items_.begin(), items_.end(), same);
    return first == items_.end() ? std::nullopt : std::optional(*std::next(first));
  }

 private:
  std::vector<Item> items_;
};

}  // namespace mapjoin
