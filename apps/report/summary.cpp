// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <apps/report/associations.hpp>
#include <apps/report/report.hpp>
#include <apps/report/verdict.hpp>
#include <mapjoin/check/checks.hpp>
#include <mapjoin/model/error.hpp>
#include <string_view>
#include <utility>
#include <vector>

namespace mapjoin::apps {
namespace {

std::string local_maps_in_words(const RunReport& run_report) {
  const RunFigures& figures = run_report.figures;
  std::string text = plural(figures.local_maps, "map");
  if (figures.local_maps > 0 && figures.poses_per_map > 0) {
    text += fmt::format(" of up to {}", plural(figures.poses_per_map, "step"));
  }
  if (figures.build_iterations > 0 && !run_report.is_resumed) text += ", " + plural(figures.build_iterations, "iteration");
  if (figures.raw_segments > 0) text += fmt::format("; {} joined as observations", plural(figures.raw_segments, "segment"));
  return text;
}

std::string solve_in_words(const MinimiseResult& result) {
  const std::string_view how = result.status == MinimiseStatus::kConverged ? "" : "DID NOT CONVERGE: ";
  return fmt::format("{}{} after {}, chi2 {:.10g}", how, to_string(result.status), plural(result.iterations, "iteration"),
                     result.chi2);
}

std::string join_in_words(const RunReport& run_report) {
  const RunOptions& options = run_report.options;
  const bool takes_start = rule_of(options.schedule).takes_start();
  const std::string_view gradually = run_report.figures.path.empty() ? "" : ", gradually,";
  const std::string start = takes_start ? fmt::format("{} from the {} start", gradually, to_string(options.start)) : "";
  const bool is_ours = options.solver.engine == Engine::kFronts;
  const std::string engine = is_ours ? "" : fmt::format(", by {}", to_string(options.solver.engine));
  return fmt::format("{}, dof {} ({}{}, {}, {} state{})", solve_in_words(run_report.figures.join), run_report.figures.join.dof,
                     to_string(options.schedule), start, to_string(options.solver.method), to_string(options.state), engine);
}

std::string recovered_in_words(const RunFigures& figures) {
  std::string text = fmt::format("chi2 {:.10g} of the whole log", *figures.recovered_chi2);
  if (figures.unrecovered > 0) text += fmt::format("; {} not to convergence", plural(figures.unrecovered, "map"));
  return text;
}

/// The NEES of what is called `what`; the truth could be moved into the frame of the map, or not.
std::string nees_in_words(std::string_view what, const Nees& nees, bool is_moved) {
  const std::string_view too_large =
      is_moved ? "OVERCONFIDENT" : "OVERCONFIDENT, unless the truth is in another frame than the map";
  const std::string_view verdict = nees.value > nees.most() ? too_large : nees.value < nees.least() ? "cautious" : "consistent";
  return fmt::format("{} {:.1f} over {} dimensions, {} ({:.0f} to {:.0f} in 98 of 100)", what, nees.value, nees.dimensions,
                     verdict, nees.least(), nees.most());
}

void add_deviations(const Deviations& deviations, Lines& lines) {
  std::vector<std::string> known;
  const auto add = [&](std::string_view what, const std::optional<Deviations::Median>& of) {
    if (!of) return;
    known.push_back(
        fmt::format("{} {:.2g} m in the map, {:.2g} m relative to where they hang", what, of->in_map, of->relative));
  };
  add("poses", deviations.poses);
  add("features", deviations.features);
  if (!known.empty()) lines.add("certainty", fmt::format("{} (median standard deviations)", fmt::join(known, "; ")));
}

void add_consistency(const RunReport& run_report, Lines& lines) {
  if (!run_report.consistency) return;
  const auto& [poses, features, joint] = *run_report.consistency;
  const bool is_moved = run_report.anchored.size() == 1;
  if (joint.dimensions == 0) lines.add("NEES", "none: the truth lacks the pose that holds the map still, or has nothing else");
  for (const auto& [what, nees] : {std::pair{"poses", &poses}, {"features", &features}, {"joint", &joint}}) {
    const bool repeats = nees == &joint && (poses.dimensions == 0 || features.dimensions == 0);
    if (nees->dimensions > 0 && !repeats) lines.add("NEES", nees_in_words(what, *nees, is_moved));
  }
}

std::string seconds_in_words(const RunReport& run_report) {
  std::vector<std::string> words;
  for (const auto& [stage, taken] : run_report.stages()) {
    if (taken > 0.0) words.push_back(fmt::format("{} {:.2f}", stage, taken));
  }
  return fmt::format("{:.2f}: {}; {:.0f} MB at most", run_report.total_seconds(), fmt::join(words, ", "), peak_memory_mb());
}

std::string fixes_in_words(const GpsReport& gps) {
  const GeographicPoint& origin = gps.frame.origin();
  std::string text = fmt::format("{}: {}", gps.file, plural(gps.fixes, "fix", "fixes"));
  if (gps.left_out > 0) text += fmt::format(", {} more at no pose", gps.left_out);
  return text +
         fmt::format("; east, north and up from {:.7f}° {:.7f}° at {:.3f} m", origin.latitude, origin.longitude, origin.height);
}

using Notes = std::vector<std::string>;

/// A function that adds a note if it holds.
auto notes_in(Notes& notes) {
  return [&notes](bool holds, std::string text) {
    if (holds) notes.push_back(std::move(text));
  };
}

void add(const Notes& notes, Lines& lines) {
  for (const std::string& text : notes) lines.add("note", text);
}

/// What was repaired or left out while the input was read.
Notes reading_notes(const RunReport& run_report) {
  Notes notes;
  const auto note = notes_in(notes);
  const MatrixRepairs& repairs = run_report.conventions.repairs;
  note(repairs.symmetrised > 0,
       fmt::format(
           "{} replaced by the symmetric part: entries across the diagonal differ by up to {:.2g} of the largest",
           plural(repairs.symmetrised, "information matrix or covariance was", "information matrices or covariances were"),
           repairs.largest_asymmetry));
  note(repairs.indefinite > 0,
       fmt::format("{} replaced by the nearest semidefinite one",
                   plural(repairs.indefinite, "indefinite information matrix was", "indefinite information matrices were")));
  note(repairs.missing > 0, fmt::format("{} without weights got the identity", plural(repairs.missing, "edge")));
  note(!run_report.counts.skipped.empty(), left_out_in_words(run_report.counts.skipped));
  return notes;
}

void add_result(const RunReport& run_report, Lines& lines) {
  const RunFigures& figures = run_report.figures;
  lines.add("join", join_in_words(run_report));
  if (figures.recovered_chi2) lines.add("recovered", recovered_in_words(figures));
  if (figures.polish) lines.add("polished", solve_in_words(*figures.polish));
  lines.add("chi2", fmt::format("{:.10g}, dof {}, {}", figures.chi2, figures.dof, gauge_in_words(run_report)));
  add_verdict(run_report, lines);
  if (run_report.deviations) add_deviations(*run_report.deviations, lines);
  add_consistency(run_report, lines);
  if (run_report.errors) add_errors(*run_report.errors, lines);
}

}  // namespace

std::string gauge_in_words(const RunReport& run_report) {
  if (run_report.gps) return "held by the fixes";
  if (run_report.anchored.empty()) return "anchored by the priors of the World";
  if (run_report.anchored.size() == 1) return to_string(run_report.anchored.front()) + " anchored";
  return fmt::format("{} and {} more anchored", to_string(run_report.anchored.front()),
                     plural(run_report.anchored.size() - 1, "pose"));
}

std::string left_out_in_words(const SkipCounts& skipped) {
  std::vector<std::string> words;
  for (const auto& [what, count] : skipped) words.push_back(fmt::format("{} ({})", what, count));
  return words.empty() ? "" : fmt::format("left out: {}", fmt::join(words, ", "));
}

std::string counts_in_words(const RunReport& run_report) {
  const Counts& counts = run_report.counts;
  std::string text =
      fmt::format("{}D, {}, {}", run_report.dimension, plural(counts.poses, "pose"), plural(counts.features, "feature"));
  const auto add = [&](std::size_t count, const std::string& thing) {
    if (count > 0) text += ", " + plural(count, thing);
  };
  add(counts.odometry, "odometry edge");
  add(counts.closures, "closure");
  add(counts.observations, "observation");
  add(counts.priors, "prior");
  add(counts.fixed_poses, "fixed pose");
  const bool has_measurements = counts.odometry + counts.closures + counts.observations > 0;
  if (has_measurements && counts.sessions > 1) add(counts.sessions, "session");
  return text;
}

std::string conventions_in_words(const Conventions& conventions, int dimension) {
  std::string text = conventions.pose_error == PoseError::kPaper ? "residual in the frame of the base (the paper's)"
                                                                 : "pose residual by g2o, turned into the frame of the base";
  if (dimension == 3) {
    text += conventions.rotation_information == RotationInformation::kVector ? ", rotation vector"
                                                                             : ", vector part of the quaternion";
  }
  text += conventions.covariance == Covariance::kOriginal ? ", original covariance" : ", identity covariance";
  for (const auto& [name, factor] : kInflatedKinds) {
    const double by = conventions.inflation.*factor;
    if (by != 1.0) text += fmt::format(", inflated {} {:g}", name, by);
  }
  return text;
}

void add_input(const RunReport& run_report, Lines& lines, std::string_view name) {
  lines.add(name, fmt::format("{}: {}", run_report.input, counts_in_words(run_report)));
  if (run_report.gps) lines.add("gps", fixes_in_words(*run_report.gps));
  if (run_report.robust) lines.add("rejected", rejected_in_words(run_report));
}

void add_convention(const RunReport& run_report, Lines& lines) {
  lines.add("convention", conventions_in_words(run_report.conventions, run_report.dimension));
}

void add_reading_notes(const RunReport& run_report, Lines& lines) {
  add(reading_notes(run_report), lines);
}

/// True if a prior of several inputs is a misfit: their frames may differ.
bool has_misfit_of_priors(const RunReport& run_report) {
  return run_report.has_several_inputs && !run_report.gps && run_report.counts.priors > 1 &&
         std::ranges::any_of(run_report.misfits, [](const NamedMisfit& of) { return of.misfit.kind == PartKind::kPrior; });
}

std::vector<std::string> notes_of(const RunReport& run_report) {
  Notes notes = reading_notes(run_report);
  const auto note = notes_in(notes);
  note(run_report.counts.repeated_edges > 0,
       fmt::format("{} between the same two poses; all of them count",
                   plural(run_report.counts.repeated_edges, "edge repeats another", "edges repeat others")));
  note(run_report.counts.repeated_steps > 0, repeated_steps_in_words(run_report.counts.repeated_steps));
  note(run_report.counts.unassociated > 0,
       fmt::format("{} left out: the file does not say of which feature",
                   plural(run_report.counts.unassociated, "observation was", "observations were")));
  note(!run_report.association && run_report.counts.shared_features > 0 && run_report.is_joined &&
           run_report.figures.fit.verdict == Verdict::kMisfit,
       fmt::format("{} taken as the same: if they are not, --features own keeps them apart; inputs of one store take it from "
                   "`mapjoin build`",
                   plural(run_report.counts.shared_features, "feature has its id in several inputs and is",
                          "features have their ids in several inputs and are")));
  const std::string remedy = remedy_in_words(run_report);
  note(!remedy.empty(), remedy);
  note(has_misfit_of_priors(run_report),
       "the priors of all inputs are of one World: if those of each are in a frame of its own, keep them in one input only, or "
       "give them as FIX, which counts in one input only");
  note(!run_report.association_is_settled,
       "the association of features had not come to rest when its joins were used up: some may still be two that are one, or "
       "one that are two; `mapjoin run` without --associate goes by their ids");
  note(run_report.is_joined && run_report.figures.converged() && !run_report.figures.join.is_confirmed.value_or(true),
       "this optimum, the best found, is not confirmed: the ways of joining end at different ones, or came to it from afar; a "
       "lower one may exist (`mapjoin compare` of a log shows where each way ends)");
  note(run_report.truth_without_features,
       "--associate named the features of the map, or of the truth: only poses are compared with it");
  note(run_report.features_not_in_truth > 0, fmt::format("{} of {} not in the truth, by name", run_report.features_not_in_truth,
                                                         plural(run_report.counts.features, "feature is", "features are")));
  note(!run_report.renamed.empty(),
       fmt::format("a map in g2o has one numbering: {}; a table (.csv) keeps all names", fmt::join(run_report.renamed, ", ")));
  note(run_report.was_damaged, "what an interrupted build had left was damaged: the build began afresh");
  const auto is_trajectory = [](const std::string& file) { return file.ends_with(".tum"); };
  note(!run_report.has_stamps && std::any_of(run_report.files.begin(), run_report.files.end(), is_trajectory),
       "the poses have no time stamps: the trajectory counts them instead");
  return notes;
}

void add_notes(const RunReport& run_report, Lines& lines) {
  add(notes_of(run_report), lines);
}

std::string summary(const RunReport& run_report) {
  Lines lines;
  add_input(run_report, lines);
  if (run_report.association) lines.add("associated", associated_in_words(run_report));
  if (run_report.has_local_maps) lines.add("local maps", local_maps_in_words(run_report));
  if (run_report.is_joined) add_result(run_report, lines);
  add_convention(run_report, lines);
  lines.add("seconds", seconds_in_words(run_report));
  if (!run_report.files.empty()) lines.add("written", fmt::format("{}", fmt::join(run_report.files, ", ")));
  add_notes(run_report, lines);
  return lines.text();
}

}  // namespace mapjoin::apps
