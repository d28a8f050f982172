// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A finished store of a log that is read in pieces, by one of several processes of which none can hold all of it.

#include <filesystem>
#include <mapjoin/io/store/contents.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// Its errors are those of read_store(), as far as the pieces go that are asked for.
class StorePieces {
 public:
  static Expected<StorePieces> open(const std::filesystem::path& path);

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
