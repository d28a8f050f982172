// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Lists of records as bytes for another rank, one list behind the other. Ranks are the same program on machines of one kind.

#include <algorithm>
#include <cstdint>
#include <mapjoin/io/store/records.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin::distributed {

/// Number of records that are encoded or decoded at a time, so that little memory is needed besides the message.
inline constexpr std::size_t kRecordsAtOnce = 4096;

class Writer {
 public:
  template <typename List>
  Writer& put(const List& records) {
    return put_if(records, [](const auto&) { return true; });
  }
  /// Puts the chosen records, as a list of their own.
  template <typename List, typename IsChosen>
  Writer& put_if(const List& records, const IsChosen& is_chosen) {
    using Record = typename List::value_type;
    const auto count = static_cast<std::uint64_t>(std::ranges::count_if(records, is_chosen));
    bytes_.reserve(bytes_.size() + sizeof count + count * store::record_size<Record>());
    bytes_ += store::encode_all(std::vector{count});
    std::vector<Record> some;
    for (const auto& record : records) {
      if (!is_chosen(record)) continue;
      some.push_back(record);
      if (some.size() == kRecordsAtOnce) put_some(some);
    }
    put_some(some);
    return *this;
  }
  const std::string& bytes() const& { return bytes_; }
  std::string bytes() && { return std::move(bytes_); }

 private:
  template <typename Record>
  void put_some(std::vector<Record>& records) {
    bytes_ += store::encode_all(records);
    records.clear();
  }

  std::string bytes_;
};

/// Takes the lists in the order in which they were put. `bytes` must outlive it.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}

  template <typename Record>
  std::vector<Record> take() {
    return list<Record>(count());
  }
  /// Calls f(record) for each record of the next list.
  template <typename Record, typename F>
  void for_each(F&& f) {
    for (std::size_t left = count(); left > 0;) {
      const std::size_t some = std::min(left, kRecordsAtOnce);
      for (const Record& record : list<Record>(some)) f(record);
      left -= some;
    }
  }
  /// Skips the next list, and returns the number of its records.
  template <typename Record>
  std::size_t skip() {
    const std::size_t records = count();
    take_bytes(records * store::record_size<Record>());
    return records;
  }
  bool is_at_end() const { return rest_.empty(); }

 private:
  std::size_t count() { return list<std::uint64_t>(1).front(); }
  template <typename Record>
  std::vector<Record> list(std::size_t count) {
    std::vector<Record> records;
    records.reserve(count);
    store::decode_all(take_bytes(count * store::record_size<Record>()), records);
    return records;
  }
  std::string_view take_bytes(std::size_t size) {
    if (size > rest_.size()) throw std::logic_error("a message between ranks is shorter than it says");
    const std::string_view bytes = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return bytes;
  }

  std::string_view rest_;
};

/// Frees the contents of a list or a message and their memory, which `list = {}` would keep.
template <typename List>
void release(List& list) {
  List().swap(list);
}

}  // namespace mapjoin::distributed
