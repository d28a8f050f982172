// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/picture.hpp>
#include <cmath>
#include <limits>
#include <mapjoin/io/output_file.hpp>
#include <string>

namespace mapjoin::apps {
namespace {

constexpr double kWidth = 1000.0;  // of the drawing, in pixels
constexpr double kMargin = 40.0;
constexpr double kFooter = 50.0;  // for scale and legend
constexpr double kFinest = 0.4;   // a line leaves out points nearer than this to the last one drawn

/// The rectangle that holds all points, and its place on the page: metres to pixels, y up.
class Page {
 public:
  template <int Dim>
  void hold(const Point<Dim>& p) {
    low_ = low_.cwiseMin(p.template head<2>());
    high_ = high_.cwiseMax(p.template head<2>());
  }
  /// Where nothing was held, or all at one place, the page shows one metre around it.
  void settle() {
    if (!(low_.x() <= high_.x())) low_ = high_ = Point<2>::Zero();
    if ((high_ - low_).maxCoeff() < 1e-6) {
      low_.array() -= 0.5;
      high_.array() += 0.5;
    }
    scale_ = (kWidth - 2.0 * kMargin) / (high_ - low_).maxCoeff();
  }
  template <int Dim>
  Point<2> at(const Point<Dim>& p) const {
    return {kMargin + (p.x() - low_.x()) * scale_, kMargin + (high_.y() - p.y()) * scale_};
  }
  double width() const { return std::max(2.0 * kMargin + (high_.x() - low_.x()) * scale_, 420.0); }
  double height() const { return 2.0 * kMargin + (high_.y() - low_.y()) * scale_ + kFooter; }
  double pixels_per_metre() const { return scale_; }
  double metres_across() const { return (width() - 2.0 * kMargin) / scale_; }

 private:
  Point<2> low_ = Point<2>::Constant(std::numeric_limits<double>::infinity());
  Point<2> high_ = -low_;
  double scale_ = 1.0;
};

/// One line per session.
template <int Dim>
std::string trajectory(const Page& page, const std::vector<Pose<Dim>>& poses, const std::vector<Session>& sessions,
                       const char* style) {
  std::string svg;
  for (const Session& session : sessions) {
    svg += "<polyline points=\"";
    Point<2> last = Point<2>::Constant(-1e9);
    for (Index k = session.begin; k < session.end; ++k) {
      const Point<2> p = page.at(poses[static_cast<std::size_t>(k)].translation);
      if ((p - last).norm() < kFinest && k + 1 < session.end) continue;
      svg += fmt::format("{:.1f},{:.1f} ", p.x(), p.y());
      last = p;
    }
    svg += fmt::format("\" {}/>\n", style);
  }
  return svg;
}

template <int Dim>
std::string dots(const Page& page, const std::vector<Point<Dim>>& features) {
  std::string svg = "<g fill=\"#c2410c\">\n";
  for (const auto& feature : features) {
    const Point<2> p = page.at(feature);
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.2\"/>\n", p.x(), p.y());
  }
  return svg + "</g>\n";
}

/// The largest of 1, 2, 5 times a power of ten that fits into a fifth of the page.
double scale_bar_metres(const Page& page) {
  const double most = page.metres_across() / 5.0;
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= most) return factor * power;
  }
  return power;
}

std::string footer(const Page& page, bool with_odometry, bool with_features) {
  const double y = page.height() - kFooter + 10.0;
  const double metres = scale_bar_metres(page);
  const double x_end = kMargin + metres * page.pixels_per_metre();
  std::string svg = fmt::format(
      "<path d=\"M{0} {1}v6H{2:.1f}v-6\" fill=\"none\" stroke=\"#222\"/>\n<text x=\"{0}\" y=\"{3}\">{4:g} m</text>\n", kMargin,
      y, x_end, y + 24.0, metres);
  double x = std::max(x_end + 30.0, kMargin + 90.0);
  const auto entry = [&](const char* colour, const char* name, double width) {
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"14\" height=\"4\" fill=\"{}\"/><text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x,
        y + 1.0, colour, x + 20.0, y + 8.0, name);
    x += width;
  };
  entry("#1d4ed8", "map", 70.0);
  if (with_features) entry("#c2410c", "features", 100.0);
  if (with_odometry) entry("#b0b0b0", "odometry alone", 120.0);
  return svg;
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
Expected<void> write_picture(const GlobalMap<Dim>& map, const std::vector<Pose<Dim>>& odometry,
                             const std::vector<Session>& sessions, const std::filesystem::path& path) {
  Page page;
  for (const auto& pose : map.poses) page.hold(pose.translation);
  for (const auto& pose : odometry) page.hold(pose.translation);
  for (const auto& feature : map.features) page.hold(feature);
  page.settle();

  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  file->write(fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      page.width(), page.height()));
  if (!odometry.empty()) {
    file->write(trajectory(page, odometry, sessions, "fill=\"none\" stroke=\"#b0b0b0\" stroke-width=\"1\""));
  }
  file->write(dots(page, map.features));
  file->write(trajectory(page, map.poses, sessions, "fill=\"none\" stroke=\"#1d4ed8\" stroke-width=\"1.4\""));
  file->write(footer(page, !odometry.empty(), !map.features.empty()));
  file->write("</svg>\n");
  return file->commit();
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                           \
  template std::vector<Pose<Dim>> dead_reckoning(const Log<Dim>&, const GlobalMap<Dim>&);                                  \
  template Expected<void> write_picture(const GlobalMap<Dim>&, const std::vector<Pose<Dim>>&, const std::vector<Session>&, \
                                        const std::filesystem::path&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
