// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a piece of work takes: time, processors, and memory.

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
  double seconds = 0.0;      ///< Of the clock on the wall.
  double cpu_seconds = 0.0;  ///< Of all threads of the process together.
  /// By how much the resident memory of the process has been larger than at the beginning (bytes), where the system tells.
  std::optional<std::int64_t> memory;
};

/// Measures from its construction on; one at a time, since it makes the system forget the largest memory so far.
class EffortMeter {
 public:
  EffortMeter();
  Effort so_far() const;

 private:
  std::optional<std::int64_t> memory_;
  std::clock_t cpu_;
  std::chrono::steady_clock::time_point start_;
};

/// The resident memory of the process (bytes) now, and at most since its start or the last EffortMeter's; nothing where the
/// system does not tell.
std::optional<std::int64_t> resident_memory();
std::optional<std::int64_t> largest_resident_memory();

}  // namespace mapjoin
