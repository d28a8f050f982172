// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A table whose states can be kept while it changes: a kept state and the table share all entries that are still the same.

#include <array>
#include <cstddef>
#include <cstdint>
#include <mapjoin/model/index.hpp>
#include <memory>
#include <vector>

namespace mapjoin {

/// Entries by index, in chunks that are never written to once a kept state has them: a write then goes to a copy of the chunk.
/// Any thread may therefore read a kept state while this one writes on. Keeping a state costs a pointer per chunk.
template <typename Index, typename T>
class SharedTable {
 public:
  SharedTable() = default;
  SharedTable(SharedTable&& other) noexcept = default;
  SharedTable& operator=(SharedTable&& other) noexcept = default;

  std::size_t size() const { return size_; }
  const T& operator[](Index index) const { return chunks_[index.position() / kChunk]->entries[index.position() % kChunk]; }

  T& writable(Index index) {
    std::shared_ptr<Chunk>& chunk = chunks_[index.position() / kChunk];
    if (chunk->made_in != states_) {
      chunk = std::make_shared<Chunk>(*chunk);
      chunk->made_in = states_;
    }
    return chunk->entries[index.position() % kChunk];
  }

  Index push_back(T entry) {
    if (size_ % kChunk == 0) chunks_.push_back(std::make_shared<Chunk>(Chunk{{}, states_}));
    const Index index(size_++);
    writable(index) = std::move(entry);
    return index;
  }

  /// The table as it is now; no later write changes it.
  SharedTable kept() {
    ++states_;
    return *this;
  }

 private:
  SharedTable(const SharedTable&) = default;  // only for kept(): two tables must not write to the same chunks

  static constexpr std::size_t kChunk = 64;
  struct Chunk {
    std::array<T, kChunk> entries;
    std::uint64_t made_in = 0;  // the number of states that were kept before
  };

  std::vector<std::shared_ptr<Chunk>> chunks_;
  std::size_t size_ = 0;
  std::uint64_t states_ = 0;
};

}  // namespace mapjoin
