// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/picture/page.hpp>
#include <apps/picture/picture.hpp>
#include <apps/report/compare_report.hpp>
#include <apps/report/report.hpp>
#include <array>
#include <filesystem>
#include <mapjoin/join/tolerances.hpp>

namespace mapjoin::apps {
namespace {

constexpr const char* kBlue = "#1d4ed8";
constexpr const char* kOrange = "#d55e00";
constexpr std::array kOtherColours{"#cc79a7", "#e69f00", "#56b4e9", "#000000"};  // of minima beside the best

constexpr double kPixels = 560.0;  // of the pictures: small enough for the words in them to be read on a phone

/// Cases that end in the same map, by its chi2.
using Solution = std::vector<std::size_t>;

/// The best first.
std::vector<Solution> solutions_of(const ComparisonFigures& comparison) {
  const auto& cases = comparison.cases;
  const auto chi2_of = [&](std::size_t k) { return cases[k].polished.chi2; };
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    if (cases[k].has_map()) order.push_back(k);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return chi2_of(a) < chi2_of(b); });
  std::vector<Solution> solutions;
  for (const std::size_t k : order) {
    if (!solutions.empty() && is_same_chi2(chi2_of(k), chi2_of(solutions.back().front()))) {
      solutions.back().push_back(k);
    } else {
      solutions.push_back({k});
    }
  }
  return solutions;
}

std::string name_of(const Solution& solution, const ComparisonFigures& comparison) {
  const CaseFigures& first = comparison.cases[solution.front()];
  const std::string who = solution.size() > 1 ? fmt::format("{} ways", solution.size()) : to_string(first.way);
  return fmt::format("chi2 {:.7g}: {}", first.polished.chi2, who);
}

/// The best solution and as many others as there are colours for.
std::size_t shown_count(const std::vector<Solution>& solutions) {
  return std::min(solutions.size(), 1 + kOtherColours.size());
}

std::string weights_in_words(Covariance covariance) {
  return fmt::format("{} covariance", to_string(covariance));
}

template <int Dim>
void add_weights(const Comparison<Dim>& comparison, const RunReport& run_report, const OtherWeights& other,
                 const GlobalMap<Dim>& other_map, const std::vector<Session>& sessions, Page& page) {
  page.heading("Original and identity covariance");
  if (!other.failure.empty()) {
    page.paragraph("With the " + weights_in_words(other.covariance) + " there is no map: " + other.failure);
    return;
  }
  const GlobalMap<Dim>& best = comparison.maps[comparison.best].polished;
  const MapDifference& apart = other.from_best;
  const auto size_of = [](const ErrorSummary& errors) {
    return fmt::format("{:.2g} m (root mean square; {:.2g} m at most)", errors.rms, errors.max);
  };
  const std::string features = apart.features.count > 0 ? ", the features by " + size_of(apart.features) : "";
  page.paragraph(fmt::format("The same log with the {} instead of the {}: the poses move by {}{}.",
                             weights_in_words(other.covariance), weights_in_words(run_report.conventions.covariance),
                             size_of(apart.poses.translation), features));
  const auto layer_of = [&](const GlobalMap<Dim>& map, Covariance covariance, const char* colour, Mark mark) {
    return Layer{
        weights_in_words(covariance), {colour}, trajectory_lines(map.poses, sessions), from_above(map.features), {}, 1.2, mark};
  };
  const std::vector<Layer> layers = {layer_of(other_map, other.covariance, kOrange, Mark::kRing),
                                     layer_of(best, run_report.conventions.covariance, kBlue, Mark::kDot)};
  page.figure(picture(layers, kPixels),
              fmt::format("Trajectories, and features: rings with the {}, dots with the {}.",
                          weights_in_words(other.covariance), weights_in_words(run_report.conventions.covariance)));
}

template <int Dim>
void add_solutions(const Comparison<Dim>& comparison, const std::vector<Solution>& solutions,
                   const std::vector<Session>& sessions, Page& page) {
  page.heading("The maps");
  std::vector<Layer> layers;
  for (std::size_t s = shown_count(solutions); s-- > 0;) {
    const GlobalMap<Dim>& map = comparison.maps[solutions[s].front()].polished;
    const bool is_best = s == 0;
    Layer layer{name_of(solutions[s], comparison),
                {is_best ? kBlue : kOtherColours[s - 1]},
                trajectory_lines(map.poses, sessions),
                is_best ? from_above(map.features) : std::vector<Point<2>>(),
                {}};
    layer.width = is_best ? 1.4 : 1.0;
    layer.is_framed = is_best;
    layers.push_back(std::move(layer));
  }
  std::string caption = "The best map: trajectory and features.";
  if (solutions.size() > 1) caption += " Beside it the trajectories of the other maps, as far as they lie within its frame.";
  if (solutions.size() > layers.size()) caption += fmt::format(" {} more are not drawn.", solutions.size() - layers.size());
  page.figure(picture(layers, kPixels), caption);
}

std::string introduction(const ComparisonFigures& comparison) {
  const auto reached = std::count_if(comparison.cases.begin(), comparison.cases.end(),
                                     [](const CaseFigures& figures) { return figures.reaches_best; });
  const CaseFigures& best = comparison.cases[comparison.best];
  return fmt::format(
      "One log, made into a map in {} ways. Full SLAM adjusts all poses and features in one least-squares problem. Joining "
      "solves short local maps first, joins them, and polishes the result on the whole log. Steps are taken in the absolute "
      "coordinates of the map, or relative to where each pose and feature hangs. In the end all minimise the same chi2, so "
      "that the least one is the best map: chi2 {:.10g} over {} degrees of freedom. {} of the {} ways reach it.",
      comparison.cases.size(), best.polished.chi2, best.run.dof, reached, comparison.cases.size());
}

}  // namespace

template <int Dim>
std::string compare_page(const RunReport& run_report, const Comparison<Dim>& comparison, const OtherWeights& other,
                         const GlobalMap<Dim>& other_map, const std::vector<Session>& sessions) {
  Page page("Joining beside full SLAM: " + std::filesystem::path(run_report.input).filename().string());
  page.paragraph(introduction(comparison));
  page.facts({{"Log", counts_in_words(run_report)},
              {"chi2", conventions_in_words(run_report.conventions, run_report.dimension)},
              {"Method", to_string(run_report.method)}});
  const std::vector<Solution> solutions = solutions_of(comparison);
  for (const NamedTable& named : tables_of(comparison)) {
    page.heading(named.name);
    page.table(named.table, named.note);
  }
  add_solutions(comparison, solutions, sessions, page);
  add_weights(comparison, run_report, other, other_map, sessions, page);
  return page.html();
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                          \
  template std::string compare_page(const RunReport&, const Comparison<Dim>&, const OtherWeights&, const GlobalMap<Dim>&, \
                                    const std::vector<Session>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
