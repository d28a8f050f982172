// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Memory for the values of a factor, on the heap or in a file.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>

namespace mapjoin {

/// An array of uninitialised numbers. In a file they are mapped: the memory of the process holds those in use, that of the
/// system the others while it has room. The file has no name, and goes with the array.
class FactorValues {
 public:
  FactorValues() = default;
  /// Allocates in memory if no folder is given. Throws std::system_error if the folder takes no such file, or the disk is too
  /// small for it.
  FactorValues(std::size_t count, const std::filesystem::path& folder);

  bool is_empty() const { return !values_; }
  double* data() const { return values_.get(); }
  /// Releases the memory of the process for these numbers until they are used again; no effect without a file.
  void set_aside(std::size_t first, std::size_t count) const;

 private:
  std::unique_ptr<double[], std::function<void(double*)>> values_;
  bool is_file_ = false;
};

}  // namespace mapjoin
