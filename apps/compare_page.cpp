// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/chart.hpp>
#include <apps/compare_page.hpp>
#include <apps/compare_table.hpp>
#include <apps/page.hpp>
#include <apps/picture.hpp>
#include <apps/summary.hpp>
#include <apps/words.hpp>
#include <array>
#include <filesystem>
#include <mapjoin/join/tolerances.hpp>
#include <numeric>

namespace mapjoin::apps {
namespace {

constexpr const char* kBlue = "#1d4ed8";
constexpr const char* kOrange = "#d55e00";
constexpr std::array kOtherColours{"#cc79a7", "#e69f00", "#56b4e9", "#000000"};  // of minima beside the best,
constexpr std::size_t kFirstOther = 3;                                           // which a chart has from this colour on
constexpr std::size_t kBlack = 6;

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

/// Of each number of steps, the first case that is joined and reaches the best map.
std::vector<const CaseFigures*> joined_cases(const ComparisonFigures& comparison) {
  std::vector<const CaseFigures*> chosen;
  for (const CaseFigures& figures : comparison.cases) {
    const bool is_known = std::any_of(chosen.begin(), chosen.end(), [&](const CaseFigures* other) {
      return other->way.poses_per_map == figures.way.poses_per_map;
    });
    if (!figures.way.is_full_slam() && figures.reaches_best && !is_known) chosen.push_back(&figures);
  }
  return chosen;
}

Chart chart_of_joined_chi2(const ComparisonFigures& comparison) {
  const double least = comparison.cases[comparison.best].polished.chi2;
  Chart chart{"chi2 before polishing, above the optimum", {"steps per local map", true}, {"chi2 / optimum - 1", true}, {}};
  Curve good{"ways that reach the best map", {}, Line::kNone, true, 0};
  Curve bad{"ways that end elsewhere", {}, Line::kNone, true, 1};
  for (const CaseFigures& figures : comparison.cases) {
    if (figures.way.is_full_slam() || !figures.has_map()) continue;
    (figures.reaches_best ? good : bad)
        .points.push_back({static_cast<double>(figures.way.poses_per_map), figures.joined.chi2 / least - 1.0});
  }
  for (Curve* curve : {&good, &bad}) {
    if (!curve->points.empty()) chart.curves.push_back(std::move(*curve));
  }
  return chart;
}

Curve curve_of(const std::string& name, const std::vector<std::size_t>& spans, const std::vector<PoseErrorSummary>& errors) {
  Curve curve{name, {}, Line::kSolid, true};
  for (std::size_t k = 0; k < errors.size(); ++k) {
    if (errors[k].translation.count > 0) curve.points.push_back({static_cast<double>(spans[k]), errors[k].translation.rms});
  }
  return curve;
}

/// Of the joined maps before polishing, and of the minima beside the best; `errors` takes them from an estimate.
template <typename Errors>
Chart chart_of_spans(const ComparisonFigures& comparison, const std::vector<Solution>& solutions, const std::string& title,
                     bool with_best, Errors&& errors) {
  Chart chart{title, {"steps from pose to pose", true}, {"RMS of position (m)", true}, {}};
  const auto add = [&](const std::string& name, const EstimateFigures& estimate, Line line, std::size_t colour) {
    chart.curves.push_back(curve_of(name, comparison.spans, errors(estimate)));
    chart.curves.back().line = line;
    chart.curves.back().colour = colour;
  };
  if (with_best) add("the best map", comparison.cases[comparison.best].polished, Line::kSolid, kBlack);
  std::size_t place = 0;
  for (const CaseFigures* figures : joined_cases(comparison)) {
    const std::string name = fmt::format("joined, {} steps per map", figures->way.poses_per_map);
    add(name, figures->joined, Line::kSolid, place++ % kFirstOther);
  }
  for (std::size_t s = 1; s < shown_count(solutions); ++s) {
    add(name_of(solutions[s], comparison), comparison.cases[solutions[s].front()].polished, Line::kDashed, kFirstOther + s - 1);
  }
  return chart;
}

std::string weights_in_words(Covariance covariance) {
  return fmt::format("{} covariance", word(covariance));
}

template <int Dim>
void add_weights(const Comparison<Dim>& comparison, const Account& account, const OtherWeights& other,
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
                             weights_in_words(other.covariance), weights_in_words(account.conventions.covariance),
                             size_of(apart.poses.translation), features));
  const auto layer_of = [&](const GlobalMap<Dim>& map, Covariance covariance, const char* colour, Mark mark) {
    return Layer{
        weights_in_words(covariance), {colour}, trajectory_lines(map.poses, sessions), from_above(map.features), {}, 1.2, mark};
  };
  const std::vector<Layer> layers = {layer_of(other_map, other.covariance, kOrange, Mark::kRing),
                                     layer_of(best, account.conventions.covariance, kBlue, Mark::kDot)};
  page.figure(picture(layers, kPixels),
              fmt::format("Trajectories, and features: rings with the {}, dots with the {}.",
                          weights_in_words(other.covariance), weights_in_words(account.conventions.covariance)));
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

void add_charts(const ComparisonFigures& comparison, const std::vector<Solution>& solutions, Page& page) {
  page.heading("What joining alone leaves to polishing");
  page.figure(svg(chart_of_joined_chi2(comparison)),
              "By what share of itself chi2 is above the optimum when the local maps are joined and not yet polished.");
  page.heading("Relative poses");
  const auto from_best = [](const EstimateFigures& estimate) { return estimate.best_spans; };
  page.figure(svg(chart_of_spans(comparison, solutions, "difference from the best map", false, from_best)),
              "The motion from every pose to the one so many steps later, beside that of the best map: what is wrong nearby "
              "shows at the left, what is wrong as a whole at the right.");
  if (!comparison.cases[comparison.best].polished.from_truth) return;
  const auto from_truth = [](const EstimateFigures& estimate) { return estimate.from_truth->spans; };
  page.figure(svg(chart_of_spans(comparison, solutions, "error against the truth", true, from_truth)),
              "The same beside the true motion (relative pose error).");
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
std::string compare_page(const Account& account, const Comparison<Dim>& comparison, const OtherWeights& other,
                         const GlobalMap<Dim>& other_map, const std::vector<Session>& sessions) {
  Page page("Joining beside full SLAM: " + std::filesystem::path(account.input).filename().string());
  page.paragraph(introduction(comparison));
  page.facts({{"Log", counts_in_words(account)},
              {"chi2", conventions_in_words(account.conventions, account.dimension)},
              {"Method", to_string(account.method)}});
  const std::vector<Solution> solutions = solutions_of(comparison);
  for (const NamedTable& named : tables_of(comparison)) {
    page.heading(named.name);
    page.table(named.table, named.note);
  }
  add_solutions(comparison, solutions, sessions, page);
  add_weights(comparison, account, other, other_map, sessions, page);
  add_charts(comparison, solutions, page);
  return page.html();
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                        \
  template std::string compare_page(const Account&, const Comparison<Dim>&, const OtherWeights&, const GlobalMap<Dim>&, \
                                    const std::vector<Session>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
