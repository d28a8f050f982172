// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/report/verdict.hpp>
#include <mapjoin/io/files/text_line.hpp>
#include <mapjoin/model/error.hpp>
#include <utility>
#include <vector>

namespace mapjoin::apps {
namespace {

std::size_t count_of(const RunReport& run_report, PartKind kind) {
  const auto is_kind = [kind](const NamedRejected& rejected) { return rejected.misfit.kind == kind; };
  return static_cast<std::size_t>(std::ranges::count_if(run_report.rejected, is_kind));
}

}  // namespace

std::string rejected_in_words(const RunReport& run_report) {
  const Counts& counts = run_report.counts;
  std::string text;
  const auto add = [&](PartKind kind, std::size_t all, const std::string& thing, const std::string& things = "") {
    if (all == 0) return;
    text += fmt::format("{}{} of {}", text.empty() ? "" : ", ", count_of(run_report, kind), plural(all, thing, things));
  };
  if (count_of(run_report, PartKind::kOdometry) > 0) add(PartKind::kOdometry, counts.odometry, "odometry edge");
  add(PartKind::kClosure, counts.closures, "closure");
  add(PartKind::kObservation, counts.observations, "observation");
  add(PartKind::kMapFeature, counts.map_features, "feature of a map", "features of maps");
  if (run_report.gps) {
    text += fmt::format("{}{} of {}", text.empty() ? "" : ", ", run_report.gps->rejected.size(),
                        plural(run_report.gps->fixes, "fix", "fixes"));
  }
  if (text.empty()) return "nothing: there are no closures or observations";
  return fmt::format("{}, with a confidence of {}", text, run_report.robust->confidence);
}

Findings rejected_findings(const RunReport& run_report) {
  std::vector<NamedRejected> rejected = run_report.rejected;
  std::ranges::stable_sort(rejected, {},
                           [](const NamedRejected& one) { return std::pair(one.misfit.probability, -one.misfit.chi2); });
  Places places;
  for (const NamedRejected& one : rejected) places.add(in_words(one));
  Findings findings;
  add_if_any(
      findings,
      {FindingLevel::kWarning, "rejected",
       fmt::format("left out by --robust, for they contradict the others: {}", plural(places.count, "measurement")), places});
  return findings;
}

Json robust_of(const RunReport& run_report) {
  if (!run_report.robust) return nullptr;
  return {{"confidence", run_report.robust->confidence},
          {"rejected", run_report.rejected.size() + (run_report.gps ? run_report.gps->rejected.size() : 0)},
          {"odometry", count_of(run_report, PartKind::kOdometry)},
          {"closures", count_of(run_report, PartKind::kClosure)},
          {"observations", count_of(run_report, PartKind::kObservation)},
          {"map_features", count_of(run_report, PartKind::kMapFeature)},
          {"fixes", run_report.gps ? run_report.gps->rejected.size() : 0}};
}

std::string rejected_as_csv(const RunReport& run_report) {
  std::string text = "kind,from,to,chi2,probability,why,from_session,to_session\n";
  for (const NamedRejected& rejected : run_report.rejected) {
    TextLine line(',');
    line.add(to_string(rejected.misfit.kind)).add(key_text(rejected.from->key));
    std::visit([&](const auto& to) { line.add(key_text(to.key)); }, rejected.to);
    line.add(rejected.misfit.chi2).add(rejected.misfit.probability).add(to_string(rejected.why));
    line.add(session_text(*rejected.from));
    line.add(std::visit([](const auto& to) { return session_text(to); }, rejected.to)).append_to(text);
  }
  if (!run_report.gps) return text;
  for (const auto& [number, pose, fix] : run_report.gps->rejected) {
    TextLine line(',');
    line.add(kFix).add(number).add(key_text(pose.key)).add(fix.chi2).add(fix.probability);
    line.add(to_string(WhyRejected::kContradicted)).add("").add(session_text(pose)).append_to(text);
  }
  return text;
}

}  // namespace mapjoin::apps
