// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// CHOLMOD's state as a value, silent and without side effects on the process, and its view of a symmetric matrix.

#include <suitesparse/cholmod.h>

#include <new>
#include <stdexcept>
#include <string>
#include <vector>

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

  /// Throws std::bad_alloc or std::runtime_error if the last call failed; a singular matrix is no failure.
  void check() const {
    if (common_.status == CHOLMOD_OUT_OF_MEMORY || common_.status == CHOLMOD_TOO_LARGE) throw std::bad_alloc();
    if (common_.status < 0) throw std::runtime_error("CHOLMOD failed with status " + std::to_string(common_.status));
  }

 private:
  cholmod_common common_{};
};

enum class Triangle { kUpper = 1, kLower = -1 };

/// One triangle of a symmetric matrix by columns, ascending or not; a pattern alone if `values` is null.
inline cholmod_sparse sparse_view(std::vector<SuiteSparse_long>& begin, std::vector<SuiteSparse_long>& rows, double* values,
                                  Triangle triangle) {
  cholmod_sparse view{};
  view.nrow = view.ncol = begin.size() - 1;
  view.nzmax = rows.size();
  view.p = begin.data();
  view.i = rows.data();
  view.x = values;
  view.stype = static_cast<int>(triangle);
  view.itype = CHOLMOD_LONG;
  view.xtype = values ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  view.dtype = CHOLMOD_DOUBLE;
  view.packed = 1;
  return view;
}

}  // namespace mapjoin
