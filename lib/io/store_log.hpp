// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log and its stretches in the tables `info` and `records` of a store (docs/store.md).

#include <mapjoin/io/store_database.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <vector>

namespace mapjoin::store {

/// What a build begins with.
template <int Dim>
struct Contents {
  const Log<Dim>& log;
  const std::vector<Stretch>& stretches;
  const std::string& options;  ///< Of the build, in the words of whoever builds.
};

/// The same, read back.
template <int Dim>
struct ReadContents {
  Log<Dim> log;
  std::vector<Stretch> stretches;
  std::string options;
};

/// Into empty tables.
template <int Dim>
Expected<void> write_contents(Database& database, const Contents<Dim>& contents);

/// Whether the tables hold these contents, to the bit.
template <int Dim>
Expected<bool> holds_contents(Database& database, const Contents<Dim>& contents);

/// 2 or 3.
Expected<int> stored_dimension(Database& database, const std::string& file);

/// Checked, see store_check.hpp. Errors begin with `file`.
template <int Dim>
Expected<ReadContents<Dim>> read_contents(Database& database, const std::string& file);

}  // namespace mapjoin::store
