// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Random numbers that are the same bits on every machine: a counter hashed by SplitMix64, and distributions written out, since
// those of the standard library differ between implementations.

#include <cstdint>
#include <optional>

namespace mapjoin {

/// One of many independent sequences under one seed. Only arithmetic and square roots are used, which IEEE 754 defines to the
/// last bit.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream);

  std::uint64_t next();
  /// A uniform deviate in [low, high).
  double uniform(double low, double high);
  /// A standard normal deviate (Marsaglia's polar method).
  double normal();

 private:
  std::uint64_t state_;
  std::optional<double> spare_;  ///< The method makes two deviates at a time.
};

/// SplitMix64's finaliser (Steele, Lea and Flood, OOPSLA 2014): a bijection that spreads every input bit over the word.
std::uint64_t mix(std::uint64_t word);

}  // namespace mapjoin
