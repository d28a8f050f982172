// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/basin_report.hpp>
#include <apps/markup.hpp>
#include <apps/words.hpp>
#include <array>
#include <cmath>
#include <vector>

namespace mapjoin::apps {
namespace {

constexpr double kNames = 300.0;  // of the column with the rows' names, in pixels
constexpr double kCellWidth = 74.0;
constexpr double kCellHeight = 26.0;
constexpr double kGap = 14.0;  // between covariances
constexpr double kMargin = 16.0;
constexpr double kHeading = 66.0;

using Colour = std::array<double, 3>;
constexpr Colour kNever = {252, 228, 214};
constexpr Colour kAlways = {29, 78, 216};

std::string colour_of(double rate) {
  std::string colour = "#";
  for (std::size_t k = 0; k < 3; ++k) {
    colour += fmt::format("{:02x}", static_cast<int>(std::lround(kNever[k] + rate * (kAlways[k] - kNever[k]))));
  }
  return colour;
}

std::string row_name(const BasinCell& cell) {
  const std::string maps = cell.split ? " (maps of " + split_in_words(cell) + ")" : "";
  return to_string(cell.formulation) + maps + ", " + to_string(cell.method);
}

std::string text(double x, double y, const char* anchor, const std::string& words, const char* style = "") {
  return fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"{}\" {}>{}</text>\n", x, y, anchor, style, words);
}

double column_at(std::size_t covariance, std::size_t start) {
  const auto cells = static_cast<double>(covariance * kBasinStarts.size() + start);
  return kMargin + kNames + kCellWidth * cells + kGap * static_cast<double>(covariance);
}

double row_at(std::size_t row) {
  return kHeading + kCellHeight * static_cast<double>(row);
}

std::string heading(const Basin& basin) {
  std::string svg;
  for (std::size_t c = 0; c < basin.covariances.size(); ++c) {
    const double middle = column_at(c, 1) + 0.5 * kCellWidth;
    svg += text(middle, 24, "middle", fmt::format("{} covariance", word(basin.covariances[c])), "font-weight=\"600\"");
    svg += text(middle, 40, "middle", fmt::format("best chi2 {:.6g}", basin.best_chi2[c]), "fill=\"#555\"");
    for (std::size_t s = 0; s < kBasinStarts.size(); ++s) {
      svg += text(column_at(c, s) + 0.5 * kCellWidth, kHeading - 8.0, "middle", to_string(kBasinStarts[s]));
    }
  }
  return svg;
}

std::string square(const BasinCell& cell, double x, double y) {
  const double rate = static_cast<double>(cell.hits()) / static_cast<double>(cell.runs.size());
  std::string words = cell.hits() == 1 ? "yes" : "no";
  if (cell.start == Start::kRandom) words = fmt::format("{}/{}", cell.hits(), cell.runs.size());
  return fmt::format("<rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"{:.0f}\" height=\"{:.0f}\" rx=\"3\" fill=\"{}\"/>\n", x + 1.0,
                     y + 1.0, kCellWidth - 2.0, kCellHeight - 2.0, colour_of(rate)) +
         text(x + 0.5 * kCellWidth, y + 0.5 * kCellHeight + 4.5, "middle", words,
              rate > 0.5 ? "fill=\"white\"" : "fill=\"#222\"");
}

}  // namespace

std::string basin_picture(const Basin& basin) {
  const std::size_t starts = kBasinStarts.size();
  const std::size_t rows = basin.cells.size() / (basin.covariances.size() * starts);
  const double width = column_at(basin.covariances.size() - 1, starts) + kMargin;
  const double height = row_at(rows) + kMargin;
  std::string svg = svg_head(width, height, 13.0) + heading(basin);
  for (std::size_t k = 0; k < basin.cells.size(); ++k) {
    const BasinCell& cell = basin.cells[k];
    const std::size_t covariance = k / (rows * starts);
    const double y = row_at(k / starts % rows);
    if (covariance == 0 && k % starts == 0) {
      svg += text(kMargin + kNames - 12.0, y + 0.5 * kCellHeight + 4.5, "end", row_name(cell));
    }
    svg += square(cell, column_at(covariance, k % starts), y);
  }
  return svg + "</svg>\n";
}

}  // namespace mapjoin::apps
