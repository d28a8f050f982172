// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/report/associations.hpp>
#include <map>
#include <mapjoin/io/files/text_line.hpp>

namespace mapjoin::apps {
namespace {

/// The number of sightings of each feature.
std::map<FeatureId, std::size_t> sightings_of_features(const RunReport& run_report) {
  std::map<FeatureId, std::size_t> sightings;
  for (const AssociatedSighting& sighting : run_report.associations) ++sightings[sighting.joined];
  return sightings;
}

std::size_t seen_once(const std::map<FeatureId, std::size_t>& sightings) {
  return static_cast<std::size_t>(std::ranges::count_if(sightings, [](const auto& feature) { return feature.second == 1; }));
}

}  // namespace

std::string associated_in_words(const RunReport& run_report) {
  if (run_report.associations.empty()) return "nothing: there are no features";
  const auto features = sightings_of_features(run_report);
  return fmt::format("{} of {}, {} of them seen once, with a confidence of {}",
                     plural(run_report.associations.size(), "sighting"), plural(features.size(), "feature"),
                     seen_once(features), run_report.association->confidence);
}

std::string untied_in_words(const std::vector<UntiedParts>& untied) {
  const UntiedParts& nearest = *std::ranges::max_element(untied, {}, [](const UntiedParts& u) { return u.alignment.score; });
  const MapAlignment& alignment = nearest.alignment;
  std::string why =
      fmt::format("at best {}, which chance may do, too", plural(alignment.pairs.size(), "feature agrees", "features agree"));
  if (alignment.pairs.empty()) why = "no four features agree";
  if (alignment.status == AlignmentStatus::kAmbiguous) {
    why = fmt::format("{} features agree at one place, {} at another", alignment.pairs.size(), alignment.other_pairs);
  }
  if (alignment.status == AlignmentStatus::kRepeated) {
    why = fmt::format("{} features agree, but lie so elsewhere, too, in the larger of the two", alignment.pairs.size());
  }
  return fmt::format("{} and {} stay apart, nothing ties them and their features do not say where they lie: {}{}",
                     to_string(nearest.first), to_string(nearest.second), why,
                     untied.size() > 1 ? fmt::format("; {} pairs of parts more stay apart", untied.size() - 1) : "");
}

Json association_of(const RunReport& run_report) {
  if (!run_report.association) return nullptr;
  const auto features = sightings_of_features(run_report);
  return {{"confidence", run_report.association->confidence},
          {"method", to_string(run_report.association->method)},
          {"sightings", run_report.associations.size()},
          {"features", features.size()},
          {"seen_once", seen_once(features)},
          {"settled", run_report.association_is_settled}};
}

std::string associations_as_csv(const RunReport& run_report) {
  std::string text = "base,feature,joined,distance,gate,alternatives,base_session\n";
  for (const AssociatedSighting& sighting : run_report.associations) {
    TextLine line(',');
    line.add(key_text(sighting.base.key)).add(key_text(sighting.name.key)).add(key_text(sighting.joined.key));
    if (sighting.distance) {
      line.add(*sighting.distance);
    } else {
      line.add("");
    }
    line.add(sighting.gate).add(sighting.alternatives).add(sighting.base.session).append_to(text);
  }
  return text;
}

}  // namespace mapjoin::apps
