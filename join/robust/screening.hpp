// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The screening of closures and observations before anything is solved.

#include <cstddef>
#include <mapjoin/join/robust/robust_map.hpp>
#include <mapjoin/join/robust/support/closure_support.hpp>
#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <mapjoin/model/log.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Evidence gathered before anything is solved: how well closures agree with odometry and with each other, and observations
/// among themselves.
template <int Dim>
struct Screening {
  OdometryChain<Dim> chain;
  SupportedClosures<Dim> closures;  ///< Within the scale of `gates`.
  double doubtful_count;            ///< Number of closures, observations and repetitions of odometry; at least 1.
  Gates gates;
  std::vector<bool> observations_count;  ///< True if others support it, and for at least one of each feature.
  std::size_t outvoted = 0;              ///< Number of closures and observations that others are against.

  /// Screens a log whose odometry is believed; incomplete once a stop is requested. `confidence` as in RobustOptions.
  Screening(const Log<Dim>& log, double confidence, const std::stop_token& stop);
  Screening(const Screening&) = delete;  // `closures` refer to `chain`
  Screening& operator=(const Screening&) = delete;

 private:
  void screen_closures();
  void screen_observations(const Log<Dim>& log);
};

}  // namespace mapjoin
