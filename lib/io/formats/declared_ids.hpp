// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The ids that the vertices of a text file declare, and their places, to name repeated and missing ones.

#include <algorithm>
#include <cstdint>
#include <mapjoin/io/files/text_scanner.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

class DeclaredIds {
 public:
  struct Item {
    std::uint64_t key;
    Place place;
  };

  void add(std::uint64_t key, const Place& place) { items_.push_back({key, place}); }
  void append(const DeclaredIds& later) { items_.insert(items_.end(), later.items_.begin(), later.items_.end()); }
  std::size_t size() const { return items_.size(); }

  /// Sorts the ids, before contains() and repetition() are called.
  void sort() {
    if (!std::ranges::is_sorted(items_, {}, &Item::key)) std::ranges::stable_sort(items_, {}, &Item::key);
  }
  bool contains(std::uint64_t key) const { return std::ranges::binary_search(items_, key, {}, &Item::key); }
  /// The second declaration of an id; nullopt if every id is declared once.
  std::optional<Item> repetition() const {
    const auto first = std::ranges::adjacent_find(items_, {}, &Item::key);
    return first == items_.end() ? std::nullopt : std::optional(*std::next(first));
  }

 private:
  std::vector<Item> items_;
};

}  // namespace mapjoin
