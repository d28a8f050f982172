// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Indices that do not mix: one type for each kind of thing counted from 0, and tables that accept only their own kind.

#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// A dense index of one kind of thing: `using PoseIndex = StrongIndex<struct PoseTag>`. Integers convert explicitly,
/// `PoseIndex(k)`, constants also implicitly, `pose == 0`, indices of another kind never.
template <typename Tag>
struct StrongIndex {
  std::int32_t value = 0;  ///< Negative only in named constants.

  constexpr StrongIndex() = default;
  template <std::integral Integer>
  consteval StrongIndex(Integer constant) : value(static_cast<std::int32_t>(constant)) {}
  template <std::integral Integer>
  constexpr explicit StrongIndex(Integer number) requires true  // preferred to the one above if both fit
      : value(static_cast<std::int32_t>(number)) {}

  /// The position in a list that is not a Table of this kind.
  constexpr std::size_t position() const { return static_cast<std::size_t>(value); }

  constexpr auto operator<=>(const StrongIndex&) const = default;
  constexpr StrongIndex& operator++() { return *this = *this + 1; }
  constexpr StrongIndex& operator--() { return *this = *this - 1; }
  constexpr StrongIndex operator++(int) { return std::exchange(*this, *this + 1); }
  constexpr StrongIndex& operator+=(std::int32_t steps) { return *this = *this + steps; }
  friend constexpr StrongIndex operator+(StrongIndex index, std::int32_t steps) { return StrongIndex(index.value + steps); }
  friend constexpr StrongIndex operator-(StrongIndex index, std::int32_t steps) { return StrongIndex(index.value - steps); }
  /// The steps from `first` to `last`.
  friend constexpr std::int32_t operator-(StrongIndex last, StrongIndex first) { return last.value - first.value; }
};

/// The position of a number or an index in a plain list.
constexpr std::size_t position_of(std::size_t number) {
  return number;
}
template <typename Tag>
constexpr std::size_t position_of(StrongIndex<Tag> index) {
  return index.position();
}

/// The indices [first, last), ascending.
template <typename Index>
struct IndexRange {
  Index first;
  Index last;

  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = Index;
    using difference_type = std::int32_t;
    using pointer = const Index*;
    using reference = Index;
    constexpr Iterator() = default;
    constexpr explicit Iterator(Index index) : index_(index) {}
    constexpr Index operator*() const { return index_; }
    constexpr Iterator& operator++() {
      ++index_;
      return *this;
    }
    constexpr Iterator operator++(int) { return std::exchange(*this, Iterator(index_ + 1)); }
    constexpr bool operator==(const Iterator&) const = default;

   private:
    Index index_;
  };

  constexpr Iterator begin() const { return Iterator(first); }
  constexpr Iterator end() const { return Iterator(last); }
  constexpr std::size_t size() const { return static_cast<std::size_t>(last - first); }
  constexpr bool contains(Index index) const { return first <= index && index < last; }
  constexpr bool operator==(const IndexRange&) const = default;
};

/// A std::vector with one entry for each index of one kind.
template <typename Index, typename T>
class Table : public std::vector<T> {
 public:
  using std::vector<T>::vector;
  explicit Table(std::vector<T> entries) : std::vector<T>(std::move(entries)) {}

  decltype(auto) operator[](Index index) { return std::vector<T>::operator[](index.position()); }
  decltype(auto) operator[](Index index) const { return std::vector<T>::operator[](index.position()); }
};

/// The indices of all entries.
template <typename Index, typename T>
IndexRange<Index> indices(const Table<Index, T>& table) {
  return {Index(0), Index(table.size())};
}

/// A list of T for each index of one kind, stored contiguously, one after the other.
template <typename Index, typename T>
class Lists {
 public:
  std::size_t size() const { return begin_.size() - 1; }
  std::span<const T> operator[](Index index) const {
    const std::size_t k = position_of(index);
    return {entries_.data() + begin_[k], entries_.data() + begin_[k + 1]};
  }
  /// All lists' entries, in order; first() is the position among them of a list's first entry.
  const std::vector<T>& entries() const { return entries_; }
  std::size_t first(Index index) const { return begin_[position_of(index)]; }
  /// The first() of each list, then the number of all entries.
  const std::vector<std::size_t>& begins() const { return begin_; }

  template <typename List>
  void push_back(const List& list) {
    entries_.insert(entries_.end(), std::begin(list), std::end(list));
    begin_.push_back(entries_.size());
  }
  void append(const Lists& others) {
    for (std::size_t k = 1; k < others.begin_.size(); ++k) begin_.push_back(entries_.size() + others.begin_[k]);
    entries_.insert(entries_.end(), others.entries_.begin(), others.entries_.end());
  }

 private:
  std::vector<std::size_t> begin_ = {0};
  std::vector<T> entries_;
};

}  // namespace mapjoin
