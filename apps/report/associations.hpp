// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What `--associate` made of the sightings, for people and for other programs.

#include <apps/report/json.hpp>
#include <apps/report/run_report.hpp>
#include <string>

namespace mapjoin::apps {

/// How many sightings are of how many features, in one line.
std::string associated_in_words(const RunReport& run_report);

/// The key `association` of the report: null where nothing was to be associated.
Json association_of(const RunReport& run_report);

/// A line for each sighting below one of names: base,feature,joined,distance,gate,alternatives,base_session. The first sighting
/// of a feature has no distance.
std::string associations_as_csv(const RunReport& run_report);

}  // namespace mapjoin::apps
