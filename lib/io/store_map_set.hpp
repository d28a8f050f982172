// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Local maps of others in a mapjoin store, which is read faster than their many files.

#include <filesystem>
#include <mapjoin/io/store.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/local_map.hpp>

namespace mapjoin {

/// Writes the set as a store without any observation, whose log has the poses and features only. As StoreWriter: the file
/// appears whole, kCannotWrite where it cannot. Throws std::invalid_argument where the set has observations beside its maps.
template <int Dim>
Expected<void> write_store(const MapSet<Dim>& set, const std::filesystem::path& path);

/// Whether a store holds maps of which nothing else is known.
template <int Dim>
bool has_maps_alone(const StoredMaps<Dim>& stored);

/// These maps as a set, read from `path`.
template <int Dim>
MapSet<Dim> map_set_of(StoredMaps<Dim> stored, const std::filesystem::path& path);

}  // namespace mapjoin
