// SPDX-License-Identifier: BSD-3-Clause
// Headers that nearly every source includes, compiled once. No source relies on this one: each includes what it uses.
#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>
