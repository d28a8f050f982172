// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <mapjoin/solve/memory_limit.hpp>

namespace mapjoin {
std::int64_t machine_memory() {
  return std::int64_t{::sysconf(_SC_PHYS_PAGES)} * ::sysconf(_SC_PAGESIZE);
}

std::string in_megabytes(std::int64_t bytes) {
  const double value = 1e-6 * static_cast<double>(bytes);
  return value < 10.0 ? fmt::format("{:.3g} MB", value) : fmt::format("{:.1f} MB", value);
}

Expected<void> check_memory(const std::string& what, std::int64_t bytes, std::int64_t limit) {
  const std::int64_t most = limit > 0 ? limit : machine_memory();
  if (bytes <= most) return {};
  return tl::unexpected(
      Error{ErrorKind::kTooLarge, fmt::format("{} would take {} of memory, more than the {} {}", what, in_megabytes(bytes),
                                              in_megabytes(most), limit > 0 ? "allowed" : "of this machine")});
}

}  // namespace mapjoin
