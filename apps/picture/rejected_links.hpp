// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What `--robust` left out of a map, as links of its picture.

#include <apps/picture/links.hpp>
#include <apps/report/run_report.hpp>
#include <filesystem>
#include <vector>

namespace mapjoin::apps {

/// Those of a run.
void add_rejected_links(const RunReport& run_report, std::vector<Link>& links);

/// Those of the `rejected.csv` in the folder of a run, under the names of its `poses.csv` and `features.csv`, for its map as it
/// was read from there; none where there is no such file. Fails with bad input where the files are not of one map.
template <int Dim>
void add_rejected_links(const std::filesystem::path& folder, const GlobalMap<Dim>& map, std::vector<Link>& links);

}  // namespace mapjoin::apps
