// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The loss of an observation: how its cost grows with its squared Mahalanobis residual s = rᵀWr.

#include <cstdint>
#include <mapjoin/model/enum_names.hpp>

namespace mapjoin {

enum class Loss : std::uint8_t {
  kQuadratic,  ///< ρ(s) = s.
};

constexpr auto enum_names(Loss) {
  return std::to_array<EnumName<Loss>>({{Loss::kQuadratic, "quadratic"}});
}

/// A loss and its slope at one s.
struct LossValue {
  double cost = 0.0;    ///< ρ(s), which chi2 sums up.
  double weight = 0.0;  ///< dρ/ds, by which Gauss-Newton scales W.
};

inline LossValue evaluate(Loss loss, double s) {
  switch (loss) {
    case Loss::kQuadratic:
      break;
  }
  return {s, 1.0};
}

}  // namespace mapjoin
