// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The association of sightings by `--associate`, for people and for other programs.

#include <apps/report/json.hpp>
#include <apps/report/run_report.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// The numbers of sightings and of features, in one line.
std::string associated_in_words(const RunReport& run_report);

/// The reason why parts of the input stay apart: the two that come nearest to being aligned, and the number of other pairs.
std::string untied_in_words(const std::vector<UntiedParts>& untied);

/// The key `association` of the report: null without --associate.
Json association_of(const RunReport& run_report);

/// CSV with a line per sighting and the header base,feature,joined,distance,gate,alternatives,base_session. The first sighting
/// of a feature has no distance, nor have those by which parts of unknown frames were aligned.
std::string associations_as_csv(const RunReport& run_report);

}  // namespace mapjoin::apps
