// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/markup.hpp>
#include <apps/picture.hpp>
#include <cmath>
#include <limits>
#include <mapjoin/io/output_file.hpp>
#include <string>

namespace mapjoin::apps {
namespace {

constexpr double kFont = 13.0;
constexpr double kMargin = 40.0;             // in pixels, as all here
constexpr double kLine = 22.0;               // of scale and legend, below the drawing
constexpr double kFinest = 0.4;              // a line leaves out points nearer than this to the last one drawn
constexpr std::size_t kMostPoints = 10'000;  // of a line, and of features: beyond, more is left out
constexpr double kLetter = 7.2;              // the mean width of one

/// The rectangle that holds all points, and its place on the sheet: metres to pixels, y up.
class Sheet {
 public:
  template <int Dim>
  void hold(const Layer<Dim>& layer) {
    if (layer.poses) {
      for (const auto& pose : *layer.poses) hold(pose.translation);
    }
    if (layer.features) {
      for (const auto& feature : *layer.features) hold(feature);
    }
  }
  template <int Dim>
  void hold(const Point<Dim>& p) {
    low_ = low_.cwiseMin(p.template head<2>());
    high_ = high_.cwiseMax(p.template head<2>());
  }
  /// Where nothing was held, or all at one place, the sheet shows one metre around it.
  void settle(double pixels) {
    if (!(low_.x() <= high_.x())) low_ = high_ = Point<2>::Zero();
    if ((high_ - low_).maxCoeff() < 1e-6) {
      low_.array() -= 0.5;
      high_.array() += 0.5;
    }
    scale_ = (pixels - 2.0 * kMargin) / (high_ - low_).maxCoeff();
  }
  template <int Dim>
  Point<2> at(const Point<Dim>& p) const {
    return {kMargin + (p.x() - low_.x()) * scale_, kMargin + (high_.y() - p.y()) * scale_};
  }
  double width() const { return std::max(2.0 * kMargin + (high_.x() - low_.x()) * scale_, 420.0); }
  double height() const { return 2.0 * kMargin + (high_.y() - low_.y()) * scale_; }
  double pixels_per_metre() const { return scale_; }
  double metres_across() const { return (width() - 2.0 * kMargin) / scale_; }

 private:
  Point<2> low_ = Point<2>::Constant(std::numeric_limits<double>::infinity());
  Point<2> high_ = -low_;
  double scale_ = 1.0;
};

/// Without the points that are too near to the last one left; the last one stays.
std::vector<Point<2>> thinned(const std::vector<Point<2>>& points, double finest) {
  std::vector<Point<2>> kept;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (kept.empty() || k + 1 == points.size() || (points[k] - kept.back()).norm() >= finest) kept.push_back(points[k]);
  }
  return kept.size() > kMostPoints ? thinned(kept, 1.5 * finest) : kept;
}

/// One line per session.
template <int Dim>
std::string trajectory(const Sheet& sheet, const Layer<Dim>& layer, const std::vector<Session>& sessions) {
  std::string svg;
  for (const Session& session : sessions) {
    std::vector<Point<2>> points;
    for (Index k = session.begin; k < session.end; ++k) {
      points.push_back(sheet.at((*layer.poses)[static_cast<std::size_t>(k)].translation));
    }
    svg += "<polyline points=\"";
    for (const Point<2>& p : thinned(points, kFinest)) svg += fmt::format("{:.1f},{:.1f} ", p.x(), p.y());
    svg += fmt::format("\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:g}\"/>\n", layer.colour, layer.width);
  }
  return svg;
}

template <int Dim>
std::string marks(const Sheet& sheet, const Layer<Dim>& layer) {
  const bool is_ring = layer.mark == Mark::kRing;
  std::string svg =
      fmt::format("<g fill=\"{}\" stroke=\"{}\">\n", is_ring ? "none" : layer.colour, is_ring ? layer.colour : "none");
  const std::size_t every = 1 + layer.features->size() / (kMostPoints + 1);
  for (std::size_t k = 0; k < layer.features->size(); k += every) {
    const Point<2> p = sheet.at((*layer.features)[k]);
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"/>\n", p.x(), p.y(), is_ring ? "4.5" : "2.2");
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

/// A line or a mark, as the layer has it.
template <int Dim>
std::string sample(const Layer<Dim>& layer, double x, double y) {
  if (layer.poses) {
    return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"14\" height=\"4\" fill=\"{}\"/>", x, y - 2.0, layer.colour);
  }
  return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>", x + 7.0, y, layer.colour);
}

/// Scale and legend, and the height of the whole picture.
struct Footer {
  std::string svg;
  double height;
};

template <int Dim>
Footer footer(const Sheet& sheet, const std::vector<Layer<Dim>>& layers) {
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
    const double width = 40.0 + kLetter * static_cast<double>(layer->name.size());
    if (x > first && x + width > sheet.width()) {
      x = first;
      y += kLine;
    }
    footer.svg += sample(*layer, x, y + 3.0) +
                  fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x + 20.0, y + 8.0, escaped(layer->name));
    x += width;
  }
  footer.height = y + 38.0;
  return footer;
}

}  // namespace

template <int Dim>
std::vector<Pose<Dim>> dead_reckoning(const Log<Dim>& log, const GlobalMap<Dim>& map) {
  std::vector<Pose<Dim>> poses = map.poses;
  for (const auto& o : log.odometry) {
    const auto base = static_cast<std::size_t>(o.base);
    const auto target = static_cast<std::size_t>(o.target);
    if (target > base) {
      poses[target] = compose(poses[base], o.measured);
    } else {
      poses[base] = compose(poses[target], inverse(o.measured));
    }
  }
  return poses;
}

template <int Dim>
std::string picture(const std::vector<Layer<Dim>>& layers, const std::vector<Session>& sessions, double pixels) {
  Sheet sheet;
  for (const auto& layer : layers) {
    if (layer.is_framed) sheet.hold(layer);
  }
  sheet.settle(pixels);
  const Footer below = footer(sheet, layers);
  std::string svg = svg_head(sheet.width(), below.height, kFont) +
                    fmt::format("<svg width=\"{:.0f}\" height=\"{:.1f}\">\n", sheet.width(), sheet.height());
  for (const auto& layer : layers) {
    if (layer.features) svg += marks(sheet, layer);
    if (layer.poses) svg += trajectory(sheet, layer, sessions);
  }
  return svg + "</svg>\n" + below.svg + "</svg>\n";
}

template <int Dim>
Expected<void> write_picture(const GlobalMap<Dim>& map, const std::vector<Pose<Dim>>& odometry,
                             const std::vector<Session>& sessions, const std::filesystem::path& path) {
  std::vector<Layer<Dim>> layers;
  if (!odometry.empty()) layers.push_back({"odometry alone", "#b0b0b0", &odometry, nullptr, 1.0});
  if (!map.features.empty()) layers.push_back({"features", "#c2410c", nullptr, &map.features});
  layers.push_back({"map", "#1d4ed8", &map.poses, nullptr});
  return write_file(path, picture(layers, sessions));
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                           \
  template std::vector<Pose<Dim>> dead_reckoning(const Log<Dim>&, const GlobalMap<Dim>&);                                  \
  template std::string picture(const std::vector<Layer<Dim>>&, const std::vector<Session>&, double);                       \
  template Expected<void> write_picture(const GlobalMap<Dim>&, const std::vector<Pose<Dim>>&, const std::vector<Session>&, \
                                        const std::filesystem::path&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
