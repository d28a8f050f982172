// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Where the values of a factor lie: in memory, or in a file.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>

namespace mapjoin {

/// So many numbers, of no value yet. In a file they are mapped: a process's memory holds those in use, and the system's the
/// others while it has room. The file has no name, and goes with this.
class FactorValues {
 public:
  FactorValues() = default;
  /// In memory where no folder is given. std::system_error where the folder takes no such file, or the disk is too small for
  /// it.
  FactorValues(std::size_t count, const std::filesystem::path& folder);

  bool is_empty() const { return !values_; }
  double* data() const { return values_.get(); }
  /// Of a file, the process's memory lets go of these until they are used again.
  void set_aside(std::size_t first, std::size_t count) const;

 private:
  std::unique_ptr<double[], std::function<void(double*)>> values_;
  bool is_file_ = false;
};

}  // namespace mapjoin
