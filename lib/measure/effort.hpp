// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Effort of a piece of work: time, processors and memory.

#include <chrono>
#include <cstdint>
#include <ctime>
#include <optional>

namespace mapjoin {

/// Adds the wall-clock seconds of its scope to `seconds`, which must outlive it.
class Stopwatch {
 public:
  explicit Stopwatch(double& seconds) : seconds_(seconds) {}
  ~Stopwatch() { seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

struct Effort {
  double seconds = 0.0;      ///< Wall-clock time (s).
  double cpu_seconds = 0.0;  ///< CPU time of all threads of the process (s).
  /// The largest growth of the resident memory of the process since the beginning (bytes); nullopt if the system does not tell.
  std::optional<std::int64_t> memory;
};

/// Measures effort from its construction on; only one at a time, since it resets the system's largest memory so far.
class EffortMeter {
 public:
  EffortMeter();
  Effort so_far() const;

 private:
  std::optional<std::int64_t> memory_;
  std::clock_t cpu_;
  std::chrono::steady_clock::time_point start_;
};

/// The resident memory of the process (bytes): now, and the largest since its start or the last EffortMeter's; nullopt if the
/// system does not tell.
std::optional<std::int64_t> resident_memory();
std::optional<std::int64_t> largest_resident_memory();

}  // namespace mapjoin
