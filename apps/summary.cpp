// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <apps/console.hpp>
#include <apps/summary.hpp>
#include <string_view>
#include <utility>
#include <vector>

namespace mapjoin::apps {
namespace {

/// "1 pose", "2 poses".
template <typename Count>
std::string count_of(Count count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::string local_maps_in_words(const Account& account) {
  const RunFigures& figures = account.figures;
  std::string text = count_of(figures.local_maps, "map", "maps");
  if (figures.local_maps > 0 && figures.poses_per_map > 0) {
    text += fmt::format(" of up to {}", count_of(figures.poses_per_map, "step", "steps"));
  }
  if (figures.build_iterations > 0 && !account.is_resumed) text += fmt::format(", {} iterations", figures.build_iterations);
  if (figures.spans > 0) text += fmt::format("; {} joined as observations", count_of(figures.spans, "stretch", "stretches"));
  return text;
}

std::string solve_in_words(const MinimiseResult& result) {
  const std::string_view how = result.status == MinimiseStatus::kConverged ? "" : "DID NOT CONVERGE: ";
  return fmt::format("{}{} after {}, chi2 {:.10g}", how, to_string(result.status),
                     count_of(result.iterations, "iteration", "iterations"), result.chi2);
}

std::string join_in_words(const Account& account) {
  const bool is_batch = account.schedule == Schedule::kBatch;
  const std::string start = is_batch ? fmt::format("{} from the {} start", account.figures.path.empty() ? "" : ", gradually,",
                                                   to_string(account.start_values))
                                     : "";
  const std::string engine = account.engine == Engine::kFronts ? "" : fmt::format(", by {}", to_string(account.engine));
  return fmt::format("{}, dof {} ({}{}, {}, {} state{})", solve_in_words(account.figures.join), account.figures.join_dof,
                     to_string(account.schedule), start, to_string(account.method), to_string(account.state), engine);
}

std::string recovered_in_words(const RunFigures& figures) {
  std::string text = fmt::format("chi2 {:.10g} of the whole log", *figures.recovered_chi2);
  if (figures.unrecovered > 0) text += fmt::format("; {} not to convergence", count_of(figures.unrecovered, "map", "maps"));
  return text;
}

std::string gauge_in_words(const Account& account) {
  if (account.held.empty()) return "held by the priors of the World";
  if (account.held.size() == 1) return to_string(account.held.front()) + " held";
  return fmt::format("{} and {} more held", to_string(account.held.front()),
                     count_of(account.held.size() - 1, "pose", "poses"));
}

std::string nees_in_words(std::string_view what, const Nees& nees) {
  const std::string_view verdict = nees.value > nees.most()    ? "OVERCONFIDENT"
                                   : nees.value < nees.least() ? "cautious"
                                                               : "consistent";
  return fmt::format("{} {:.1f} over {} dimensions, {} ({:.0f} to {:.0f} in 98 of 100)", what, nees.value, nees.dimensions,
                     verdict, nees.least(), nees.most());
}

std::string deviations_in_words(const Account& account) {
  const Deviations& all = *account.deviations;
  const auto words = [](std::string_view what, const Deviations::Median& of) {
    return fmt::format("{} {:.2g} m in the map, {:.2g} m relative to where they hang", what, of.in_map, of.relative);
  };
  std::string text = words("poses", all.poses);
  if (account.counts.features > 0) text += "; " + words("features", all.features);
  return text + " (median standard deviations)";
}

void add_consistency(const Account& account, Lines& lines) {
  if (!account.consistency) return;
  const auto& [poses, features, joint] = *account.consistency;
  for (const auto& [what, nees] : {std::pair{"poses", &poses}, {"features", &features}, {"joint", &joint}}) {
    const bool repeats = nees == &joint && (poses.dimensions == 0 || features.dimensions == 0);
    if (nees->dimensions > 0 && !repeats) lines.add("NEES", nees_in_words(what, *nees));
  }
}

std::string seconds_in_words(const Account& account) {
  const RunSeconds& seconds = account.figures.seconds;
  const std::pair<const char*, double> stages[] = {{"read", account.read_seconds},  {"build", seconds.build},
                                                   {"join", seconds.join},          {"recover", seconds.recover},
                                                   {"polish", seconds.polish},      {"covariances", seconds.covariances},
                                                   {"write", account.write_seconds}};
  std::vector<std::string> words;
  for (const auto& [stage, taken] : stages) {
    if (taken > 0.0) words.push_back(fmt::format("{} {:.2f}", stage, taken));
  }
  return fmt::format("{:.2f}: {}; {:.0f} MB at most", account.total_seconds(), fmt::join(words, ", "), peak_memory_mb());
}

void add_result(const Account& account, Lines& lines) {
  const RunFigures& figures = account.figures;
  lines.add("join", join_in_words(account));
  if (figures.recovered_chi2) lines.add("recovered", recovered_in_words(figures));
  if (figures.polish) lines.add("polished", solve_in_words(*figures.polish));
  lines.add("chi2", fmt::format("{:.10g}, dof {}, {}", figures.chi2, figures.dof, gauge_in_words(account)));
  if (account.deviations) lines.add("certainty", deviations_in_words(account));
  add_consistency(account, lines);
}

}  // namespace

std::string counts_in_words(const Account& account) {
  const Counts& counts = account.counts;
  std::string text = fmt::format("{}D, {}, {}", account.dimension, count_of(counts.poses, "pose", "poses"),
                                 count_of(counts.features, "feature", "features"));
  const auto add = [&](std::size_t count, std::string_view one, std::string_view many) {
    if (count > 0) text += ", " + count_of(count, one, many);
  };
  add(counts.odometry, "odometry edge", "odometry edges");
  add(counts.closures, "closure", "closures");
  add(counts.observations, "observation", "observations");
  add(counts.priors, "prior", "priors");
  add(counts.fixed_poses, "fixed pose", "fixed poses");
  if (counts.sessions > 1) add(counts.sessions, "session", "sessions");
  return text;
}

std::string conventions_in_words(const Conventions& conventions, int dimension) {
  std::string text = conventions.pose_error == PoseError::kPaper ? "residual in the frame of the base (the paper's)"
                                                                 : "pose residual by g2o, turned into the frame of the base";
  if (dimension == 3) {
    text += conventions.rotation_information == RotationInformation::kVector ? ", rotation vector"
                                                                             : ", vector part of the quaternion";
  }
  return text + (conventions.covariance == Covariance::kOriginal ? ", original covariance" : ", identity covariance");
}

std::vector<std::string> remarks(const Account& account) {
  std::vector<std::string> all;
  if (account.conventions.repaired_informations > 0) {
    all.push_back(fmt::format("{} replaced by the nearest semidefinite one",
                              count_of(account.conventions.repaired_informations, "indefinite information matrix was",
                                       "indefinite information matrices were")));
  }
  if (account.counts.repeated_edges > 0) {
    all.push_back(fmt::format("{} between the same two poses; all of them count",
                              count_of(account.counts.repeated_edges, "edge repeats another", "edges repeat others")));
  }
  if (account.counts.unassociated > 0) {
    all.push_back(fmt::format("{} left out: the file does not say of which feature",
                              count_of(account.counts.unassociated, "observation was", "observations were")));
  }
  const auto is_trajectory = [](const std::string& file) { return file.ends_with(".tum"); };
  if (!account.has_stamps && std::any_of(account.files.begin(), account.files.end(), is_trajectory)) {
    all.push_back("the poses have no time stamps: the trajectory counts them instead");
  }
  return all;
}

std::string summary(const Account& account) {
  Lines lines;
  lines.add("input", fmt::format("{}: {}", account.input, counts_in_words(account)));
  if (account.has_local_maps) lines.add("local maps", local_maps_in_words(account));
  if (account.is_joined) add_result(account, lines);
  lines.add("convention", conventions_in_words(account.conventions, account.dimension));
  lines.add("seconds", seconds_in_words(account));
  if (!account.files.empty()) lines.add("written", fmt::format("{}", fmt::join(account.files, ", ")));
  for (const std::string& remark : remarks(account)) lines.add("note", remark);
  return lines.text();
}

}  // namespace mapjoin::apps
