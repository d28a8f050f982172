// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Common operations on lists.

#include <algorithm>
#include <iterator>
#include <optional>
#include <vector>

namespace mapjoin {

template <typename List, typename More>
void append(List& list, const More& more) {
  list.insert(list.end(), more.begin(), more.end());
}

/// Sorts a list and keeps each value once.
template <typename List>
void make_distinct(List& list) {
  std::ranges::sort(list);
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

/// The least element that a list has more than once, if any.
template <typename List>
auto repeated(const List& list) {
  std::vector sorted(list.begin(), list.end());
  if (!std::ranges::is_sorted(sorted)) std::ranges::sort(sorted);
  const auto twice = std::ranges::adjacent_find(sorted);
  return twice == sorted.end() ? std::nullopt : std::optional(*twice);
}

/// At most `most` of the wanted elements of a list, or of all, spread evenly.
template <typename T, typename Predicate>
std::vector<T> evenly_chosen(const std::vector<T>& list, std::size_t most, Predicate&& is_wanted) {
  std::vector<T> chosen;
  chosen.reserve(list.size());
  std::copy_if(list.begin(), list.end(), std::back_inserter(chosen), is_wanted);
  if (chosen.size() <= most) return chosen;
  for (std::size_t k = 0; k < most; ++k) chosen[k] = chosen[k * chosen.size() / most];
  chosen.resize(most);
  return chosen;
}
template <typename T>
std::vector<T> evenly_chosen(const std::vector<T>& list, std::size_t most) {
  return evenly_chosen(list, most, [](const T&) { return true; });
}

}  // namespace mapjoin
