// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <mapjoin/simulate/random_stream.hpp>
#include <numbers>

namespace mapjoin {
namespace {

constexpr std::uint64_t kGoldenGamma = 0x9e3779b97f4a7c15;

/// ln x of a normal number x > 0: with x = m 2^e and m near 1, e ln 2 + 2 artanh((m - 1)/(m + 1)), by its series.
double natural_log(double x) {
  int exponent = 0;
  double m = std::frexp(x, &exponent);
  if (m < 0.5 * std::numbers::sqrt2) {
    m *= 2.0;
    --exponent;
  }
  const double z = (m - 1.0) / (m + 1.0);  // At most 0.172: twelve terms are exact to rounding.
  double series = 0.0;
  for (int k = 23; k >= 1; k -= 2) series = series * z * z + 1.0 / k;
  return exponent * std::numbers::ln2 + 2.0 * z * series;
}

}  // namespace

std::uint64_t mix(std::uint64_t word) {
  word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9;
  word = (word ^ (word >> 27)) * 0x94d049bb133111eb;
  return word ^ (word >> 31);
}

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t stream) : state_(mix(seed + mix(stream + kGoldenGamma))) {}

std::uint64_t RandomStream::next() {
  state_ += kGoldenGamma;
  return mix(state_);
}

double RandomStream::uniform(double low, double high) {
  constexpr double kUnit = 1.0 / (std::uint64_t{1} << 53);
  return low + (high - low) * (static_cast<double>(next() >> 11) * kUnit);
}

double RandomStream::normal() {
  if (spare_) {
    const double deviate = *spare_;
    spare_.reset();
    return deviate;
  }
  while (true) {
    const double u = uniform(-1.0, 1.0);
    const double v = uniform(-1.0, 1.0);
    const double s = u * u + v * v;
    if (s >= 1.0 || s == 0.0) continue;
    const double scale = std::sqrt(-2.0 * natural_log(s) / s);
    spare_ = v * scale;
    return u * scale;
  }
}

}  // namespace mapjoin
