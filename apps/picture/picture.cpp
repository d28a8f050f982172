// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <apps/picture/markup.hpp>
#include <apps/picture/picture.hpp>
#include <cmath>
#include <numbers>
#include <string_view>

namespace mapjoin::apps {
namespace {

constexpr double kMargin = 40.0;             // in pixels, as all lengths here
constexpr double kLeastWidth = 520.0;        // of a sheet, for the legend
constexpr double kLine = 22.0;               // height of a line of the legend, below the drawing
constexpr double kFinest = 0.4;              // a line leaves out points nearer than this to the last one drawn
constexpr std::size_t kMostPoints = 10'000;  // of all lines of a layer, of its marks, of its ellipses
constexpr double kLetter = 7.2;              // the mean width of a letter
constexpr double kSample = 24.0;             // the width of a sample in the legend
constexpr std::size_t kSampleColours = 4;    // the most colours that a sample shows

/// The rectangle that holds all framed layers, and its place on the sheet: metres to pixels, y up.
class Sheet {
 public:
  /// The sheet shows one metre if nothing is framed or all is at one place.
  Sheet(const std::vector<Layer>& layers, double pixels) {
    for (const Layer& layer : layers) {
      if (!layer.is_framed) continue;
      for (const FlatLine& line : layer.lines) extend(line);
      extend(layer.marks);
      for (const Ellipse& e : layer.ellipses) extend(e);
    }
    if (box_.isEmpty()) box_.extend(Point<2>::Zero().eval());
    if (box_.sizes().maxCoeff() < 1e-6) {
      box_.min().array() -= 0.5;
      box_.max().array() += 0.5;
    }
    scale_ = (pixels - 2.0 * kMargin) / box_.sizes().maxCoeff();
  }
  Point<2> at(const Point<2>& p) const {
    return {kMargin + (p.x() - box_.min().x()) * scale_, kMargin + (box_.max().y() - p.y()) * scale_};
  }
  double width() const { return std::max(2.0 * kMargin + box_.sizes().x() * scale_, kLeastWidth); }
  double height() const { return 2.0 * kMargin + box_.sizes().y() * scale_; }
  double pixels_per_metre() const { return scale_; }
  double metres_across() const { return (width() - 2.0 * kMargin) / scale_; }

 private:
  void extend(const std::vector<Point<2>>& points) {
    for (const Point<2>& p : points) box_.extend(p);
  }
  void extend(const Ellipse& e) {
    const Point<2> half = (Rotation<2>(e.angle).matrix() * e.half_axes.asDiagonal()).rowwise().norm();
    box_.extend(e.centre - half).extend(e.centre + half);
  }

  Eigen::AlignedBox2d box_;
  double scale_;
};

/// The line without points that are too near to the last one kept; its end is kept.
FlatLine thinned(const FlatLine& points, double finest) {
  FlatLine kept;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (kept.empty() || k + 1 == points.size() || (points[k] - kept.back()).norm() >= finest) kept.push_back(points[k]);
  }
  return kept;
}

/// One in so many items of a list is drawn, each of at least `points` points.
std::size_t one_in(std::size_t items, std::size_t points = 1) {
  return 1 + points * items / (kMostPoints + 1);
}

/// The items of a list that are drawn: of very many some are skipped.
template <typename T>
std::vector<T> some_of(const std::vector<T>& all, std::size_t every) {
  std::vector<T> some;
  for (std::size_t k = 0; k < all.size(); k += every) some.push_back(all[k]);
  return some;
}

/// True if a line begins where the one before it ends, as the paths of local maps do.
bool goes_on(const FlatLine& before, const FlatLine& line) {
  return before.back() == line.front();
}

/// Lines of a path, each of `most` ones that go on from each other in one.
std::vector<FlatLine> joined(const std::vector<FlatLine>& lines, std::size_t most) {
  std::vector<FlatLine> joined;
  std::size_t count = most;  // of lines in the last one
  for (const FlatLine& line : lines) {
    if (count == most || !goes_on(joined.back(), line)) {
      joined.emplace_back();
      count = 0;
    }
    joined.back().insert(joined.back().end(), line.begin(), line.end());
    ++count;
  }
  return joined;
}

/// Few enough lines: of very many those of a path are joined, and of others, as of links or of a path in very many pieces, some
/// are skipped.
std::vector<FlatLine> few_of(const std::vector<FlatLine>& lines) {
  const std::size_t every = one_in(lines.size(), 2);
  std::size_t going_on = 0;
  for (std::size_t k = 1; k < lines.size(); ++k) going_on += goes_on(lines[k - 1], lines[k]) ? 1 : 0;
  if (2 * going_on <= lines.size()) return some_of(lines, every);
  const std::vector<FlatLine> of_path = joined(lines, every);
  return some_of(of_path, one_in(of_path.size()));
}

/// The lines in pixels, thinned until few enough points are left in all.
std::vector<FlatLine> lines_on(const Sheet& sheet, const std::vector<FlatLine>& lines) {
  std::vector<FlatLine> drawn = few_of(lines);
  for (FlatLine& line : drawn) {
    for (Point<2>& p : line) p = sheet.at(p);
  }
  double finest = kFinest;
  std::size_t points = 0;
  do {
    points = 0;
    for (FlatLine& line : drawn) {
      line = thinned(line, finest);
      points += line.size() > 2 ? line.size() : 0;
    }
    finest *= 1.5;
  } while (points > kMostPoints);
  return drawn;
}

const char* dashes(const Layer& layer) {
  return layer.is_dashed ? " stroke-dasharray=\"6 3\"" : "";
}

double radius(Mark mark) {
  return mark == Mark::kDot ? 2.2 : mark == Mark::kRing ? 4.5 : 1.5;
}

/// What a pen with a round tip draws; "" if that is nothing.
std::string strokes(const std::string& way, const std::string& colour, double width, const char* dashes) {
  if (way.empty()) return "";
  return fmt::format(
      "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:g}\" stroke-linejoin=\"round\" "
      "stroke-linecap=\"round\"{}/>\n",
      way, colour, width, dashes);
}

std::string lines_of(const Sheet& sheet, const Layer& layer) {
  const std::vector<FlatLine> lines = lines_on(sheet, layer.lines);
  const auto colours = std::min(layer.colours.size(), lines.size());
  std::string svg;
  for (std::size_t c = 0; c < colours; ++c) {
    std::string way;
    std::string dots;  // lines of one point
    for (std::size_t k = c; k < lines.size(); k += layer.colours.size()) {
      std::string& drawn = lines[k].size() == 1 ? dots : way;
      for (std::size_t p = 0; p < lines[k].size(); ++p) {
        drawn += fmt::format("{}{:.1f},{:.1f}", p == 0 ? "M" : " ", lines[k][p].x(), lines[k][p].y());
      }
      if (lines[k].size() == 1) drawn += "h0";
    }
    svg += strokes(way, layer.colours[c], layer.width, dashes(layer)) +
           strokes(dots, layer.colours[c], std::max(layer.width, 2.0 * radius(Mark::kDot)), "");
  }
  return svg;
}

std::string paint(const Layer& layer, bool is_outline) {
  const std::string& colour = layer.colours.front();
  return fmt::format("fill=\"{}\" stroke=\"{}\"", is_outline ? "none" : colour, is_outline ? colour : "none");
}

std::string marks_of(const Sheet& sheet, const Layer& layer) {
  if (layer.marks.empty()) return "";
  std::string svg = "<g " + paint(layer, layer.mark == Mark::kRing) + ">\n";
  for (const Point<2>& mark : some_of(layer.marks, one_in(layer.marks.size()))) {
    const Point<2> p = sheet.at(mark);
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"/>\n", p.x(), p.y(), radius(layer.mark));
  }
  return svg + "</g>\n";
}

std::string ellipses_of(const Sheet& sheet, const Layer& layer) {
  if (layer.ellipses.empty()) return "";
  std::string svg = fmt::format("<g {} stroke-width=\"{:g}\">\n", paint(layer, true), layer.width);
  for (const Ellipse& e : some_of(layer.ellipses, one_in(layer.ellipses.size()))) {
    const Point<2> centre = sheet.at(e.centre);
    const Point<2> half = e.half_axes * sheet.pixels_per_metre();
    svg += fmt::format("<ellipse rx=\"{:.2f}\" ry=\"{:.2f}\" transform=\"translate({:.1f} {:.1f}) rotate({:.1f})\"/>\n",
                       half.x(), half.y(), centre.x(), centre.y(), -e.angle * 180.0 / std::numbers::pi);
  }
  return svg + "</g>\n";
}

/// The largest of 1, 2, 5 times a power of ten that fits into a fifth of the sheet.
double scale_bar_metres(const Sheet& sheet) {
  const double most = sheet.metres_across() / 5.0;
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= most) return factor * power;
  }
  return power;
}

/// A small sample of what the layer draws, with its middle at the height y.
std::string sample(const Layer& layer, double x, double y) {
  std::string svg;
  const std::size_t colours = std::min(layer.colours.size(), kSampleColours);
  const double part = kSample / static_cast<double>(colours);
  for (std::size_t c = 0; c < colours && !layer.lines.empty(); ++c) {
    svg += fmt::format("<path d=\"M{:.1f} {:.1f}h{:.1f}\" stroke=\"{}\" stroke-width=\"{:g}\"{}/>",
                       x + part * static_cast<double>(c), y, part, layer.colours[c], std::max(layer.width, 2.0), dashes(layer));
  }
  const double middle = x + 0.5 * kSample;
  if (!layer.ellipses.empty()) {
    svg += fmt::format("<ellipse cx=\"{:.1f}\" cy=\"{:.1f}\" rx=\"9\" ry=\"5\" {}/>", middle, y, paint(layer, true));
  }
  if (!layer.marks.empty()) {
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" {}/>", middle, y, std::max(radius(layer.mark), 3.0),
                       paint(layer, layer.mark == Mark::kRing));
  }
  return svg;
}

/// Where the characters of a text begin: all but continuation bytes of UTF-8.
std::vector<std::size_t> characters(std::string_view text) {
  std::vector<std::size_t> begins;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if ((static_cast<unsigned char>(text[k]) & 0xC0U) != 0x80U) begins.push_back(k);
  }
  return begins;
}

/// The text without its middle if it is wider than `width`.
std::string shortened(const std::string& text, double width) {
  const std::vector<std::size_t> begins = characters(text);
  const auto most = static_cast<std::size_t>(std::max(width / kLetter, 3.0));
  if (begins.size() <= most) return text;
  return text.substr(0, begins[most / 2]) + "…" + text.substr(begins[begins.size() - (most - 1) / 2]);
}

/// Scale and legend, and the height of the whole picture.
struct Footer {
  std::string svg;
  double height;
};

Footer footer(const Sheet& sheet, const std::vector<Layer>& layers) {
  const double metres = scale_bar_metres(sheet);
  const double x_end = kMargin + metres * sheet.pixels_per_metre();
  double y = sheet.height() + 12.0;
  Footer footer;
  footer.svg = fmt::format(
      "<path d=\"M{0} {1:.1f}v6H{2:.1f}v-6\" fill=\"none\" stroke=\"#222\"/>\n<text x=\"{0}\" y=\"{3:.1f}\">{4:g} m</text>\n",
      kMargin, y, x_end, y + 24.0, metres);
  const double first = std::max(x_end + 30.0, kMargin + 90.0);
  double x = first;
  for (auto layer = layers.rbegin(); layer != layers.rend(); ++layer) {
    if (layer->name.empty()) continue;
    const std::string name = shortened(layer->name, sheet.width() - first - kSample - 28.0);
    const double width = kSample + 28.0 + kLetter * static_cast<double>(characters(name).size());
    if (x > first && x + width > sheet.width()) {
      x = first;
      y += kLine;
    }
    footer.svg += sample(*layer, x, y + 3.0) +
                  fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x + kSample + 7.0, y + 8.0, escaped(name));
    x += width;
  }
  footer.height = y + 38.0;
  return footer;
}

}  // namespace

Ellipse ellipse(const Point<2>& centre, const Matrix<2>& P, double sigmas) {
  const Eigen::SelfAdjointEigenSolver<Matrix<2>> eigen(P);
  const Point<2> axis = eigen.eigenvectors().col(1);
  const Point<2> variances = eigen.eigenvalues().cwiseMax(0.0).reverse();
  return {centre, sigmas * variances.cwiseSqrt(), std::atan2(axis.y(), axis.x())};
}

std::string picture(const std::vector<Layer>& layers, double pixels) {
  const Sheet sheet(layers, pixels);
  const Footer below = footer(sheet, layers);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
      "<svg width=\"{0:.0f}\" height=\"{2:.1f}\">\n",
      sheet.width(), below.height, sheet.height());
  for (const Layer& layer : layers) svg += ellipses_of(sheet, layer) + marks_of(sheet, layer) + lines_of(sheet, layer);
  return svg + "</svg>\n" + below.svg + "</svg>\n";
}

}  // namespace mapjoin::apps
