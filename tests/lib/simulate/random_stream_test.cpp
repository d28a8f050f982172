// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/simulate/random_stream.hpp>
#include <vector>

namespace mapjoin {
namespace {

/// The largest distance of the sample's distribution function from `distribution`, times √n (Kolmogorov and Smirnov).
template <typename F>
double kolmogorov(std::vector<double> sample, F&& distribution) {
  std::sort(sample.begin(), sample.end());
  const auto n = static_cast<double>(sample.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    const double below = distribution(sample[i]);
    largest = std::max({largest, below - static_cast<double>(i) / n, static_cast<double>(i + 1) / n - below});
  }
  return std::sqrt(n) * largest;
}

constexpr double kOneInTenThousand = 2.23;  // Kolmogorov's statistic exceeds it with probability 1e-4

TEST(RandomStream, MixIsSplitMix64) {
  // The generator's published first outputs for seed 1234567.
  const std::uint64_t gamma = 0x9e3779b97f4a7c15;
  EXPECT_EQ(mix(1234567 + gamma), 6457827717110365317u);
  EXPECT_EQ(mix(1234567 + 2 * gamma), 3203168211198807973u);
}

TEST(RandomStream, UniformDeviatesAreUniform) {
  RandomStream random(7, 0);
  std::vector<double> sample(100'000);
  for (double& x : sample) x = random.uniform(-2.0, 3.0);
  EXPECT_LT(kolmogorov(sample, [](double x) { return (x + 2.0) / 5.0; }), kOneInTenThousand);
}

TEST(RandomStream, NormalDeviatesAreNormal) {
  RandomStream random(7, 1);
  std::vector<double> sample(100'000);
  for (double& x : sample) x = random.normal();
  EXPECT_LT(kolmogorov(sample, [](double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }), kOneInTenThousand);
  // Two deviates come from one draw: successive ones must be uncorrelated, and so must their squares.
  double product = 0.0;
  double square_product = 0.0;
  for (std::size_t i = 0; i + 1 < sample.size(); ++i) {
    product += sample[i] * sample[i + 1];
    square_product += (sample[i] * sample[i] - 1.0) * (sample[i + 1] * sample[i + 1] - 1.0);
  }
  EXPECT_LT(std::abs(product), 4.0 * std::sqrt(1e5));
  EXPECT_LT(std::abs(square_product), 4.0 * std::sqrt(4e5));
}

TEST(RandomStream, StreamsAndSeedsDifferAndAreRepeatable) {
  EXPECT_EQ(RandomStream(1, 2).next(), RandomStream(1, 2).next());
  EXPECT_NE(RandomStream(1, 2).next(), RandomStream(2, 1).next());
  EXPECT_NE(RandomStream(1, 2).next(), RandomStream(1, 3).next());
}

}  // namespace
}  // namespace mapjoin
