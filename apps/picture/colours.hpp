// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The colours of curves and maps that are to be told apart.

#include <array>

namespace mapjoin::apps {

/// Okabe and Ito's, for all kinds of colour vision; without their yellow, which is too light for a line.
inline constexpr std::array kDistinctColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"};

}  // namespace mapjoin::apps
