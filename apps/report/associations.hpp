// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What `--associate` made of the sightings, for people and for other programs.

#include <apps/report/json.hpp>
#include <apps/report/run_report.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// How many sightings are of how many features, in one line.
std::string associated_in_words(const RunReport& run_report);

/// Why parts of the input stay apart: the two that come nearest to being aligned, and how many pairs more.
std::string untied_in_words(const std::vector<UntiedParts>& untied);

/// The key `association` of the report: null where nothing was to be associated.
Json association_of(const RunReport& run_report);

/// A line for each sighting below one of names: base,feature,joined,distance,gate,alternatives,base_session. The first sighting
/// of a feature has no distance, nor have those by which parts of unknown frames were laid on each other.
std::string associations_as_csv(const RunReport& run_report);

}  // namespace mapjoin::apps
