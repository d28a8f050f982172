// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// CHOLMOD's state as a value: silent, and without side effects on the process.

#include <suitesparse/cholmod.h>

#include <new>
#include <stdexcept>
#include <string>

namespace mapjoin {

/// Workspace and parameters of CHOLMOD (64-bit indices) for one thread. Nothing is printed; errors are exceptions.
class Cholmod {
 public:
  Cholmod() {
    cholmod_l_start(&common_);
    common_.print = 0;
    common_.error_handler = nullptr;
  }
  ~Cholmod() { cholmod_l_finish(&common_); }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  cholmod_common* get() { return &common_; }
  cholmod_common* operator->() { return &common_; }

  /// Throws std::bad_alloc or std::runtime_error where the last call failed; a singular matrix is no failure.
  void check() const {
    if (common_.status == CHOLMOD_OUT_OF_MEMORY || common_.status == CHOLMOD_TOO_LARGE) throw std::bad_alloc();
    if (common_.status < 0) throw std::runtime_error("CHOLMOD failed with status " + std::to_string(common_.status));
  }

 private:
  cholmod_common common_{};
};

}  // namespace mapjoin
