// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A finished store of a log that is read in pieces, by one of several processes of which none can hold all of it.

#include <filesystem>
#include <mapjoin/io/store/contents.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// Its errors are those of read_store(), as far as the pieces go that are asked for.
class StorePieces {
 public:
  /// check() is yet to be called, by one of the processes at least.
  static Expected<StorePieces> open(const std::filesystem::path& path);
  /// Reads all of the file.
  Expected<void> check() { return store::check_database(database_); }

  Expected<int> dimension() { return store::stored_dimension(database_); }
  /// The log without factors, times and initial values, and no maps.
  template <int Dim>
  Expected<StoredMaps<Dim>> outline() {
    return store::read_outline<Dim>(database_);
  }
  /// Whether another store has the same log, with its factors or but for them, to the bit.
  Expected<bool> has_log_of(StorePieces& other, bool with_factors);

  /// The numbers of the pieces that the factors stand in.
  Expected<std::vector<std::int64_t>> factor_chunks();
  /// Those in some of them, whose indices and numbers are yet to be checked.
  template <int Dim>
  Expected<void> read_factors(std::span<const std::int64_t> chunks, FactorGraph<Dim>& graph) {
    return store::read_factors(database_, chunks, graph);
  }

  /// Whether a build would begin with these contents, to the bit.
  template <int Dim>
  Expected<bool> holds(const store::Contents<Dim>& contents);

  /// Of those of `segments`, which are the store's, that are maps here, in their order; nothing where one did not determine a
  /// map.
  template <int Dim>
  Expected<std::vector<std::optional<LocalMap<Dim>>>> maps(const Log<Dim>& log, const std::vector<Segment>& segments);

 private:
  explicit StorePieces(store::Database database) : database_(std::move(database)) {}

  store::Database database_;
};

}  // namespace mapjoin
