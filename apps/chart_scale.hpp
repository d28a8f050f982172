// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// From values to places along an axis, and where the axis has its ticks.

#include <optional>
#include <string>
#include <vector>

namespace mapjoin::apps {

struct Axis {
  std::string label;
  bool is_logarithmic = false;
  std::optional<double> low = std::nullopt;  ///< Where it begins and ends; where left open, as its values and ticks need.
  std::optional<double> high = std::nullopt;
};

struct Tick {
  double value = 0.0;
  std::string label;  ///< Without the scale's factor.
};

class Scale {
 public:
  /// Holds every value that is finite and, on a logarithmic axis, positive. Without any, a linear axis is [0, 1], a logarithmic
  /// one [1, 10].
  Scale(const Axis& axis, const std::vector<double>& values);

  /// Whether a value has a place on the axis, be it beyond its ends.
  bool takes(double value) const;
  /// 0 where the axis begins, 1 where it ends.
  double share(double value) const;
  /// At multiples of 1, 2 or 5 times a power of ten; on a logarithmic axis of some length at powers of ten.
  const std::vector<Tick>& ticks() const { return ticks_; }
  /// By which all labels are to be multiplied, as "×10⁸"; often empty.
  const std::string& factor() const { return factor_; }

 private:
  void settle_linear(const Axis& axis);
  void settle_logarithmic(const Axis& axis);

  bool is_logarithmic_;
  double low_;
  double high_;
  std::vector<Tick> ticks_;
  std::string factor_;
};

}  // namespace mapjoin::apps
