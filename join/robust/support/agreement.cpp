// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/robust/support/agreement.hpp>
#include <mapjoin/parallel/parallel.hpp>

namespace mapjoin {
namespace {

constexpr double kMostOfAGroup = 3.0 * kMostOfAPair;
/// Rounds of the fixed-point iteration; in the first kHardening of them decisions harden.
constexpr int kRounds = 60;
constexpr double kHardening = 20.0;

double odds_of(const PriorOdds& prior, const std::vector<Agreement>& agreements, const std::vector<double>& right) {
  double odds = prior.evidence;
  for (auto a = agreements.begin(); a != agreements.end();) {
    double of_group = 0.0;
    for (const auto group = a->group; a != agreements.end() && a->group == group; ++a) {
      of_group += right[a->other] * static_cast<double>(a->evidence);
    }
    odds += std::clamp(of_group, -kMostOfAGroup, kMostOfAGroup);
  }
  return odds;
}

}  // namespace

std::vector<double> odds_by_agreement(const std::vector<PriorOdds>& priors, const Agreements& agreements) {
  std::vector<double> right(priors.size(), 0.5);
  for (std::size_t k = 0; k < right.size(); ++k) {
    if (priors[k].is_right || priors[k].is_wrong) right[k] = priors[k].is_right ? 1.0 : 0.0;
  }
  std::vector<double> odds(priors.size());
  for (int round = 1; round <= kRounds; ++round) {
    const double hardness = std::min(1.0, round / kHardening);
    parallel_chunks(odds.size(), kObservationsPerPiece, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) odds[k] = odds_of(priors[k], agreements[k], right);
    });
    for (std::size_t k = 0; k < right.size(); ++k) {
      if (priors[k].is_right || priors[k].is_wrong) continue;
      right[k] = 0.5 * (right[k] + 1.0 / (1.0 + std::exp(-hardness * odds[k])));
    }
  }
  return odds;
}

}  // namespace mapjoin
