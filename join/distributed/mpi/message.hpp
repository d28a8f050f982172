// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Lists of records as bytes for another rank, one list behind the other. Ranks are the same program on machines of one kind.

#include <cstdint>
#include <mapjoin/io/store/records.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin::distributed {

class Writer {
 public:
  template <typename List>
  Writer& put(const List& records) {
    bytes_ += store::encode_all(std::vector<std::uint64_t>{records.size()});
    bytes_ += store::encode_all(records);
    return *this;
  }
  const std::string& bytes() const& { return bytes_; }
  std::string bytes() && { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Takes the lists in the order in which they were put. `bytes` outlive it.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}

  template <typename Record>
  std::vector<Record> take() {
    const auto count = list<std::uint64_t>(1).front();
    return list<Record>(count);
  }
  bool is_at_end() const { return rest_.empty(); }

 private:
  template <typename Record>
  std::vector<Record> list(std::size_t count) {
    const std::size_t size = count * store::record_size<Record>();
    std::vector<Record> records;
    records.reserve(count);
    if (size > rest_.size() || !store::decode_all(rest_.substr(0, size), records)) {
      throw std::logic_error("a message between ranks is shorter than it says");
    }
    rest_.remove_prefix(size);
    return records;
  }

  std::string_view rest_;
};

/// Gives up what a list or a message holds, and its memory, which `list = {}` would keep.
template <typename List>
void release(List& list) {
  List().swap(list);
}

}  // namespace mapjoin::distributed
