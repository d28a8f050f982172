// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <fstream>
#include <mapjoin/measure/effort.hpp>
#include <string>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace mapjoin {
namespace {

/// A figure of /proc/self/status, given there in kB of 1024 bytes; nullopt if it is not there.
std::optional<std::int64_t> status_bytes(const std::string& wanted) {
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key; status.ignore(256, '\n')) {
    std::int64_t kibibytes = 0;
    if (key == wanted && status >> kibibytes) return 1024 * kibibytes;
  }
  return std::nullopt;
}

/// Returns free memory to the system: what the allocator keeps of earlier work would hide later growth.
void give_back_free_memory() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

bool forget_largest_memory() {
  std::ofstream references("/proc/self/clear_refs");
  references << '5' << std::flush;
  return references.good();
}

}  // namespace

EffortMeter::EffortMeter() {
  give_back_free_memory();
  if (forget_largest_memory()) memory_ = resident_memory();
  cpu_ = std::clock();
  start_ = std::chrono::steady_clock::now();
}

Effort EffortMeter::so_far() const {
  Effort effort;
  effort.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  effort.cpu_seconds = static_cast<double>(std::clock() - cpu_) / CLOCKS_PER_SEC;
  const auto largest = largest_resident_memory();
  if (memory_ && largest) effort.memory = std::max<std::int64_t>(0, *largest - *memory_);
  return effort;
}

std::optional<std::int64_t> resident_memory() {
  return status_bytes("VmRSS:");
}

std::optional<std::int64_t> largest_resident_memory() {
  return status_bytes("VmHWM:");
}

}  // namespace mapjoin
