// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/chart_scale.hpp>
#include <array>
#include <cmath>

namespace mapjoin::apps {
namespace {

constexpr int kMostSteps = 6;         // between the ticks of a linear axis
constexpr double kFewDecades = 2.0;   // up to here a logarithmic axis has ticks within its decades
constexpr double kHair = 1e-9;        // of a step: what rounding may do
constexpr double kLargeLabel = 1e5;   // from here on, and
constexpr double kSmallLabel = 1e-3;  // below, labels have a factor
constexpr double kLargest = 1e300;    // so that differences are finite

double power_of_ten(int exponent) {
  return std::pow(10.0, exponent);
}

std::string power_label(int exponent) {
  constexpr std::array kDigits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string label = exponent < 0 ? "10⁻" : "10";
  for (const char digit : fmt::format("{}", std::abs(exponent))) label += kDigits[static_cast<std::size_t>(digit - '0')];
  return label;
}

/// The least of 1, 2, 5 times a power of ten of which at most kMostSteps go into the length.
double step_for(double length) {
  const double least = length / kMostSteps * (1.0 - kHair);
  const double power = power_of_ten(static_cast<int>(std::floor(std::log10(least))));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least) return factor * power;
  }
  return 10.0 * power;
}

/// 1, 2 and 5 times the powers of ten from just below `low` to just above `high`.
std::vector<double> one_two_five(double low, double high) {
  std::vector<double> values;
  const auto first = static_cast<int>(std::floor(std::log10(low) + kHair));
  const auto last = static_cast<int>(std::floor(std::log10(high) + kHair)) + 1;
  for (int exponent = first - 1; exponent <= last; ++exponent) {
    for (const double factor : {1.0, 2.0, 5.0}) values.push_back(factor * power_of_ten(exponent));
  }
  const auto is_below = [&](double v) { return v <= low * (1.0 + kHair); };
  const auto begin = std::partition_point(values.begin(), values.end(), is_below) - 1;
  const auto is_inside = [&](double v) { return v < high * (1.0 - kHair); };
  return {begin, std::partition_point(begin, values.end(), is_inside) + 1};
}

}  // namespace

Scale::Scale(const Axis& axis, const std::vector<double>& values)
    : is_logarithmic_(axis.is_logarithmic), low_(is_logarithmic_ ? 1.0 : 0.0), high_(is_logarithmic_ ? 10.0 : 1.0) {
  bool is_first = true;
  for (const double value : values) {
    if (!takes(value)) continue;
    low_ = is_first ? value : std::min(low_, value);
    high_ = is_first ? value : std::max(high_, value);
    is_first = false;
  }
  low_ = axis.low.value_or(low_);
  high_ = axis.high.value_or(high_);
  if (is_logarithmic_) {
    settle_logarithmic(axis);
  } else {
    settle_linear(axis);
  }
}

bool Scale::takes(double value) const {
  return std::abs(value) <= kLargest && (!is_logarithmic_ || value > 0.0);
}

double Scale::share(double value) const {
  if (is_logarithmic_) return std::log(value / low_) / std::log(high_ / low_);
  return (value - low_) / (high_ - low_);
}

void Scale::settle_linear(const Axis& axis) {
  // A range that is lost in the digits of its values would have ticks that cannot be told apart.
  const double least = std::max(1e-9 * std::max(std::abs(low_), std::abs(high_)), 1e-300);
  if (!(high_ - low_ > least)) {
    const double half = low_ == 0.0 ? 0.5 : 0.5 * std::abs(low_);
    low_ -= half;
    high_ += half;
  }
  const double step = step_for(high_ - low_);
  const double first = axis.low ? std::ceil(low_ / step - kHair) : std::floor(low_ / step + kHair);
  const double last = axis.high ? std::floor(high_ / step + kHair) : std::ceil(high_ / step - kHair);
  if (!axis.low) low_ = first * step;
  if (!axis.high) high_ = last * step;

  const double largest = std::max(std::abs(first), std::abs(last)) * step;
  const bool has_factor = largest >= kLargeLabel || largest < kSmallLabel;
  const auto exponent = has_factor ? static_cast<int>(std::floor(std::log10(largest) + kHair)) : 0;
  if (has_factor) factor_ = "×" + power_label(exponent);
  const double shown_step = step / power_of_ten(exponent);
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(shown_step) + kHair)));
  for (double k = first; k <= last; ++k) {
    ticks_.push_back({k * step, fmt::format("{:.{}f}", k == 0.0 ? 0.0 : k * shown_step, decimals)});
  }
}

void Scale::settle_logarithmic(const Axis& axis) {
  if (!(high_ > low_ * (1.0 + kHair))) high_ = low_ * 2.0;
  std::vector<double> values;
  const bool is_short = std::log10(high_ / low_) <= kFewDecades;
  if (is_short) {
    values = one_two_five(low_, high_);
  } else {
    const auto first = static_cast<int>(std::floor(std::log10(low_) + kHair));
    const auto last = static_cast<int>(std::ceil(std::log10(high_) - kHair));
    const int stride = (last - first + kMostSteps - 1) / kMostSteps;
    for (int exponent = first; exponent < last + stride; exponent += stride) values.push_back(power_of_ten(exponent));
  }
  if (!axis.low) low_ = values.front();
  if (!axis.high) high_ = values.back();
  for (const double value : values) {
    if (share(value) < -kHair || share(value) > 1.0 + kHair) continue;
    const auto exponent = static_cast<int>(std::floor(std::log10(value) + kHair));
    const bool is_plain = is_short && value >= kSmallLabel && value < kLargeLabel;
    const auto factor = std::lround(value / power_of_ten(exponent));
    const std::string scientific = factor == 1 ? power_label(exponent) : fmt::format("{}·{}", factor, power_label(exponent));
    ticks_.push_back({value, is_plain ? fmt::format("{:.{}f}", value, std::max(0, -exponent)) : scientific});
  }
}

}  // namespace mapjoin::apps
