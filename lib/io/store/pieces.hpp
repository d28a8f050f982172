// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A finished store that is read in pieces, by one of several processes none of which can hold the whole log.

#include <filesystem>
#include <mapjoin/io/store/contents.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// A finished store, read in pieces; errors are those of read_store() that concern the pieces asked for.
class StorePieces {
 public:
  /// Opens a store; at least one of the processes must then call check().
  static Expected<StorePieces> open(const std::filesystem::path& path);
  /// Checks the database, for which it reads the whole file.
  Expected<void> check() { return store::check_database(database_); }

  Expected<int> dimension() { return store::stored_dimension(database_); }
  /// The log without factors, times and initial values, and without maps.
  template <int Dim>
  Expected<StoredMaps<Dim>> outline() {
    return store::read_outline<Dim>(database_);
  }
  /// True if another store has the same log, bit by bit, with or without its factors.
  Expected<bool> has_log_of(StorePieces& other, bool with_factors);

  /// The numbers of the chunks that hold the factors.
  Expected<std::vector<std::int64_t>> factor_chunks();
  /// Appends the factors in some of factor_chunks(); their indices and numbers are yet to be checked.
  template <int Dim>
  Expected<void> read_factors(std::span<const std::int64_t> chunks, FactorGraph<Dim>& graph) {
    return store::read_factors(database_, chunks, graph);
  }

  /// True if a build with these contents would begin as this store does, bit by bit.
  template <int Dim>
  Expected<bool> holds(const store::Contents<Dim>& contents);

  /// The maps of those of the store's `segments` that are maps, in their order; nullopt for a segment that did not determine
  /// one.
  template <int Dim>
  Expected<std::vector<std::optional<LocalMap<Dim>>>> maps(const Log<Dim>& log, const std::vector<Segment>& segments);

 private:
  explicit StorePieces(store::Database database) : database_(std::move(database)) {}

  store::Database database_;
};

}  // namespace mapjoin
