// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <mapjoin/solve/engines/factor_values.hpp>
#include <mapjoin/solve/memory_limit.hpp>
#include <string>
#include <system_error>

namespace mapjoin {
namespace {

[[noreturn]] void fail(const std::filesystem::path& folder, std::size_t bytes, int reason) {
  throw std::system_error(
      reason, std::generic_category(),
      fmt::format("{}: no room for a file of {}", folder.string(), in_megabytes(static_cast<std::int64_t>(bytes))));
}

/// Maps a new file without a name, with disk space allocated for all its bytes.
double* mapped_file(const std::filesystem::path& folder, std::size_t bytes) {
  std::string name = (folder / "factor-XXXXXX").string();
  const int file = ::mkostemp(name.data(), O_CLOEXEC);
  if (file < 0) fail(folder, bytes, errno);
  ::unlink(name.c_str());
  int reason = ::posix_fallocate(file, 0, static_cast<::off_t>(bytes));
  void* const data = reason == 0 ? ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
  if (reason == 0 && data == MAP_FAILED) reason = errno;
  ::close(file);
  if (reason != 0) fail(folder, bytes, reason);
  return static_cast<double*>(data);
}

}  // namespace

FactorValues::FactorValues(std::size_t count, const std::filesystem::path& folder) : is_file_(!folder.empty() && count > 0) {
  if (is_file_) {
    const std::size_t bytes = count * sizeof(double);
    values_ = {mapped_file(folder, bytes), [bytes](double* data) { ::munmap(data, bytes); }};
  } else {
    values_ = {std::make_unique_for_overwrite<double[]>(count).release(), [](double* data) { delete[] data; }};
  }
}

void FactorValues::set_aside(std::size_t first, std::size_t count) const {
  if (!is_file_) return;
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t begin = (first * sizeof(double) + page - 1) / page * page;
  const std::size_t end = (first + count) * sizeof(double) / page * page;
  // Data written to a shared mapping stay in the file.
  if (begin < end) ::madvise(reinterpret_cast<std::byte*>(data()) + begin, end - begin, MADV_DONTNEED);
}

}  // namespace mapjoin
