// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The loss of an observation: how its cost grows with its squared Mahalanobis residual s = rᵀWr.

#include <algorithm>
#include <cmath>
#include <limits>

namespace mapjoin {

/// The loss ρ(s): s up to `quadratic_to`, the constant c² from `constant_from` on, with c⁴ the product of both, and between
/// them the smooth arc 2 c √(s μ (μ + 1)) - μ (c² + s) of graduated non-convexity (Yang, Antonante, Tzoumas and Carlone,
/// "Graduated non-convexity for robust spatial perception", 2020). Least squares by default.
struct Loss {
  double quadratic_to = std::numeric_limits<double>::infinity();
  double constant_from = std::numeric_limits<double>::infinity();

  /// Truncated least squares, min(s, c²), if `share` is 1; a smaller one, above 0, gives a longer arc, [share·c², c²/share].
  static Loss truncated(double c2, double share = 1.0) { return {share * c2, c2 / share}; }
  /// The loss of a factor that does not count: it costs nothing and pulls nowhere.
  static constexpr Loss dropped() { return {0.0, 0.0}; }
  bool operator==(const Loss&) const = default;
};

/// True if the loss is quadratic everywhere, or has ends 0 < quadratic_to ≤ constant_from with a finite product, c⁴, above 0.
inline bool is_valid(const Loss& loss) {
  const double c4 = loss.quadratic_to * loss.constant_from;
  return loss == Loss{} ||
         (c4 > 0.0 && std::isfinite(c4) && loss.quadratic_to > 0.0 && loss.quadratic_to <= loss.constant_from);
}

/// The value of a loss and its slope at one s.
struct LossValue {
  double cost = 0.0;    ///< ρ(s), a term of chi2.
  double weight = 0.0;  ///< dρ/ds, by which Gauss-Newton scales W.
};

inline LossValue evaluate(const Loss& loss, double s) {
  if (s < loss.quadratic_to) return {s, 1.0};
  const double c2 = std::sqrt(loss.quadratic_to * loss.constant_from);
  if (s >= loss.constant_from) return {c2, 0.0};
  const double share = std::sqrt(loss.quadratic_to / loss.constant_from);
  const double mu = share / (1.0 - share);
  const double root = std::sqrt(c2 * mu * (mu + 1.0));
  return {2.0 * root * std::sqrt(s) - mu * (c2 + s), root / std::sqrt(s) - mu};
}

/// The share that graduated non-convexity begins with if the worst s is `excess` times c²: it is then still on the arc. 1,
/// without graduation, if `excess` is not finite.
inline double first_share(double excess) {
  return std::isfinite(excess) ? 0.5 / std::max(1.0, excess) : 1.0;
}

/// The next share after this one, which is above 0: the control parameter of graduated non-convexity, μ = share / (1 - share),
/// is doubled.
inline double sharper(double share) {
  const double mu = 2.0 * share / (1.0 - share);
  return mu / (1.0 + mu);
}

}  // namespace mapjoin
