// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The covariances of a map as JSON, by docs/report.md.

#include <filesystem>
#include <mapjoin/join/map_covariances.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>

namespace mapjoin::apps {

/// Where the covariances of a map go that is one file: `map.covariances.json` beside `map.g2o`.
std::filesystem::path covariance_file(const std::filesystem::path& map);

/// The marginal covariances that `map` holds, of the estimate named; kCannotWrite.
template <int Dim>
Expected<void> write_covariances(const GlobalMap<Dim>& map, Estimate estimate, const std::filesystem::path& path);

}  // namespace mapjoin::apps
