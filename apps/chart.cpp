// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/chart.hpp>
#include <apps/colours.hpp>
#include <apps/markup.hpp>
#include <string_view>

namespace mapjoin::apps {
namespace {

constexpr double kFont = 12.0;
constexpr double kCharacter = 0.58 * kFont;  // the mean width of one
constexpr double kLine = 18.0;               // from one line of text to the next
constexpr double kRight = 18.0;              // margins around the plot
constexpr double kTop = 34.0;
constexpr double kBottom = 46.0;
constexpr double kSample = 22.0;  // of a line, in the legend

/// Roughly, in pixels: the bytes of UTF-8 that begin a character are counted.
double width_of(std::string_view text) {
  const auto begins = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; };
  return kCharacter * static_cast<double>(std::count_if(text.begin(), text.end(), begins));
}

const char* colour_of(const Curve& curve, std::size_t place) {
  return kDistinctColours[curve.colour.value_or(place) % kDistinctColours.size()];
}

std::string text(double x, double y, std::string_view anchor, std::string_view words, std::string_view more = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, more, escaped(words));
}

/// One chart with its upper left corner at the origin.
class Drawing {
 public:
  explicit Drawing(const Chart& chart)
      : chart_(chart), x_(chart.x, values_of(chart, true)), y_(chart.y, values_of(chart, false)) {
    double widest = 0.0;
    for (const Tick& tick : y_.ticks()) widest = std::max(widest, width_of(tick.label));
    left_ = widest + (chart.y.label.empty() ? 18.0 : 36.0);
    plot_width_ = chart.width - left_ - kRight;
    plot_height_ = chart.height - kTop - kBottom;
    place_legend();
  }

  double height() const { return chart_.height + kLine * static_cast<double>(legend_.empty() ? 0 : legend_.back().row + 1); }

  std::string svg() const { return grid() + labels() + curves() + legend(); }

 private:
  struct Entry {
    std::size_t curve;
    double x;
    std::size_t row;
  };

  static std::vector<double> values_of(const Chart& chart, bool of_x) {
    std::vector<double> values;
    for (const Curve& curve : chart.curves) {
      for (const CurvePoint& point : curve.points) {
        values.push_back(of_x ? point.x : point.y);
        if (!of_x) values.insert(values.end(), {point.low, point.high});
      }
    }
    return values;
  }

  double across(double x) const { return x_.share(x) * plot_width_; }
  double down(double y) const { return (1.0 - y_.share(y)) * plot_height_; }

  void place_legend() {
    double x = left_;
    std::size_t row = 0;
    for (std::size_t c = 0; c < chart_.curves.size(); ++c) {
      const std::string& name = chart_.curves[c].name;
      if (name.empty()) continue;
      const double width = kSample + 24.0 + width_of(name);
      if (x > left_ && x + width > chart_.width) {
        x = left_;
        ++row;
      }
      legend_.push_back({c, x, row});
      x += width;
    }
  }

  std::string grid() const {
    std::string lines;
    for (const Tick& tick : x_.ticks())
      lines += fmt::format("M{:.1f} {:.1f}v{:.1f}", left_ + across(tick.value), kTop, plot_height_);
    for (const Tick& tick : y_.ticks())
      lines += fmt::format("M{:.1f} {:.1f}h{:.1f}", left_, kTop + down(tick.value), plot_width_);
    return fmt::format(
        "<path d=\"{}\" stroke=\"#e2e2e2\" fill=\"none\"/>\n<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" "
        "stroke=\"#555\" fill=\"none\"/>\n",
        lines, left_, kTop, plot_width_, plot_height_);
  }

  std::string labels() const {
    const double bottom = kTop + plot_height_;
    const double middle = left_ + 0.5 * plot_width_;
    std::string out = text(middle, 20.0, "middle", chart_.title, " font-weight=\"bold\"");
    for (const Tick& tick : x_.ticks()) out += text(left_ + across(tick.value), bottom + 16.0, "middle", tick.label);
    for (const Tick& tick : y_.ticks()) out += text(left_ - 6.0, kTop + down(tick.value) + 4.0, "end", tick.label);
    out += text(middle, bottom + 36.0, "middle", chart_.x.label);
    if (!x_.factor().empty()) out += text(left_ + plot_width_, bottom + 32.0, "end", x_.factor());
    if (!y_.factor().empty()) out += text(left_, kTop - 6.0, "start", y_.factor());
    const double height = kTop + 0.5 * plot_height_;
    return out + text(14.0, height, "middle", chart_.y.label, fmt::format(" transform=\"rotate(-90 14.0 {:.1f})\"", height));
  }

  /// Whether a point lies beyond the ends that an axis was given.
  bool is_beyond(const CurvePoint& point) const {
    const auto is_outside = [](double share) { return share < -1e-9 || share > 1.0 + 1e-9; };
    return has_place(point) && (is_outside(x_.share(point.x)) || is_outside(y_.share(point.y)));
  }

  /// What lies beyond the axes is cut off by a viewport of its own.
  std::string curves() const {
    const bool is_cut = std::any_of(chart_.curves.begin(), chart_.curves.end(), [&](const Curve& curve) {
      return std::any_of(curve.points.begin(), curve.points.end(), [&](const CurvePoint& point) { return is_beyond(point); });
    });
    std::string out = fmt::format("<svg x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" overflow=\"{}\">\n", left_,
                                  kTop, plot_width_, plot_height_, is_cut ? "hidden" : "visible");
    for (std::size_t c = 0; c < chart_.curves.size(); ++c) {
      const Curve& curve = chart_.curves[c];
      const char* colour = colour_of(curve, c);
      out += curve.has_markers ? bars(curve, colour) : band(curve, colour);
    }
    for (std::size_t c = 0; c < chart_.curves.size(); ++c) out += curve(chart_.curves[c], colour_of(chart_.curves[c], c));
    return out + "</svg>\n";
  }

  bool has_place(const CurvePoint& point) const { return x_.takes(point.x) && y_.takes(point.y); }
  bool has_band(const CurvePoint& point) const { return x_.takes(point.x) && y_.takes(point.low) && y_.takes(point.high); }

  std::string bars(const Curve& curve, const char* colour) const {
    std::string path;
    for (const CurvePoint& point : curve.points) {
      if (has_band(point)) path += fmt::format("M{:.1f} {:.1f}V{:.1f}", across(point.x), down(point.high), down(point.low));
    }
    return path.empty() ? path : fmt::format("<path d=\"{}\" stroke=\"{}\" stroke-opacity=\"0.5\"/>\n", path, colour);
  }

  std::string band(const Curve& curve, const char* colour) const {
    std::string path;
    for (auto begin = curve.points.begin(); begin != curve.points.end();) {
      begin = std::find_if(begin, curve.points.end(), [&](const CurvePoint& point) { return has_band(point); });
      const auto end = std::find_if(begin, curve.points.end(), [&](const CurvePoint& point) { return !has_band(point); });
      if (begin == end) break;
      for (auto p = begin; p != end; ++p)
        path += fmt::format("{}{:.1f} {:.1f}", p == begin ? 'M' : 'L', across(p->x), down(p->high));
      for (auto p = end; p != begin;) {
        --p;
        path += fmt::format("L{:.1f} {:.1f}", across(p->x), down(p->low));
      }
      path += 'Z';
      begin = end;
    }
    return path.empty() ? path : fmt::format("<path d=\"{}\" fill=\"{}\" fill-opacity=\"0.18\"/>\n", path, colour);
  }

  std::string curve(const Curve& curve, const char* colour) const {
    std::string path, markers;
    bool is_broken = true;
    for (const CurvePoint& point : curve.points) {
      if (!has_place(point)) {
        is_broken = true;
        continue;
      }
      // A point alone between two gaps is a line of no length, which round ends make a dot.
      path += fmt::format("{}{:.1f} {:.1f}{}", is_broken ? 'M' : 'L', across(point.x), down(point.y), is_broken ? "h0" : "");
      if (curve.has_markers) markers += marker(across(point.x), down(point.y), colour);
      is_broken = false;
    }
    if (path.empty()) return path;
    return (curve.line == Line::kNone ? "" : stroke(path, curve, colour)) + markers;
  }

  static std::string stroke(const std::string& path, const Curve& curve, const char* colour) {
    return fmt::format(
        "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\" stroke-linejoin=\"round\" "
        "stroke-linecap=\"round\"{}/>\n",
        path, colour, curve.line == Line::kDashed ? " stroke-dasharray=\"5 4\"" : "");
  }

  static std::string marker(double x, double y, const char* colour) {
    return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.8\" fill=\"{}\"/>\n", x, y, colour);
  }

  std::string legend() const {
    std::string out;
    for (const Entry& entry : legend_) {
      const Curve& curve = chart_.curves[entry.curve];
      const char* colour = colour_of(curve, entry.curve);
      const double y = chart_.height + kLine * static_cast<double>(entry.row) + 8.0;
      if (curve.line != Line::kNone) out += stroke(fmt::format("M{:.1f} {:.1f}h{:.1f}", entry.x, y, kSample), curve, colour);
      if (curve.has_markers) out += marker(entry.x + 0.5 * kSample, y, colour);
      out += text(entry.x + kSample + 6.0, y + 4.0, "start", curve.name);
    }
    return out;
  }

  const Chart& chart_;
  Scale x_;
  Scale y_;
  double left_ = 0.0;
  double plot_width_ = 0.0;
  double plot_height_ = 0.0;
  std::vector<Entry> legend_;
};

}  // namespace

std::string svg(const Chart& chart) {
  return svg(std::vector{chart}, 1);
}

std::string svg(const std::vector<Chart>& charts, std::size_t columns) {
  columns = std::max<std::size_t>(columns, 1);
  std::string panels;
  double width = 0.0;
  double height = 0.0;
  for (std::size_t first = 0; first < charts.size(); first += columns) {
    double row_width = 0.0;
    double row_height = 0.0;
    for (std::size_t c = first; c < std::min(first + columns, charts.size()); ++c) {
      const Drawing drawing(charts[c]);
      panels += fmt::format("<g transform=\"translate({:.1f} {:.1f})\">\n{}</g>\n", row_width, height, drawing.svg());
      row_width += charts[c].width;
      row_height = std::max(row_height, drawing.height());
    }
    width = std::max(width, row_width);
    height += row_height;
  }
  return svg_head(width, height + 10.0, kFont) + panels + "</svg>\n";
}

}  // namespace mapjoin::apps
