// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Who is who between the logs of several stores, whose local maps are built.

#include <mapjoin/io/store/contents.hpp>
#include <mapjoin/join/association/associate.hpp>

namespace mapjoin {

/// Finds out which features of different inputs are the same, as associate() does in their logs, and calls those of the local
/// maps by what they are found to be. A map inside which a feature was marginalised that others turn out to see, too, gives way
/// to its observations, so that the join is that of one log. Throws std::invalid_argument unless names hold: the maps were
/// built by them. Errors as of associate().
template <int Dim>
Expected<Associated<StoredMaps<Dim>>> associate(const StoredMaps<Dim>& stored, const AssociationOptions& options,
                                                const std::stop_token& stop = {});

}  // namespace mapjoin
