// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A map in relative form as a table, by docs/report.md.

#include <filesystem>
#include <mapjoin/join/map_covariances.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>

namespace mapjoin::apps {

/// Where the relations of a map go that is one file: `map.relations.csv` beside `map.g2o`.
std::filesystem::path relation_file(const std::filesystem::path& map);

/// One line per pose, after that of its parent, then one per feature; kCannotWrite.
template <int Dim>
Expected<void> write_relations(const GlobalMap<Dim>& map, const MarginalCovariances<Dim>& marginals,
                               const std::filesystem::path& path);

}  // namespace mapjoin::apps
