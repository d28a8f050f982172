// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The local maps of a store.

#include <mapjoin/io/store.hpp>
#include <string>

namespace mapjoin::store {

/// Appends the map of every stretch of `stored` that is one, checked beside its log; where it was not determined, the stretch
/// becomes a span. Bad input, in a sentence that begins with `file`: a map is missing, or not what check_map() asks for.
template <int Dim>
Expected<void> read_maps(Database& database, const std::string& file, StoredMaps<Dim>& stored);

}  // namespace mapjoin::store
