// SPDX-License-Identifier: BSD-3-Clause
#include <dlfcn.h>

#include <mapjoin/solve/blas.hpp>

namespace mapjoin {
namespace {

/// A loaded library with those that it brings along, or nothing.
class Library {
 public:
  /// What the program was linked with.
  static Library of_program() { return Library(dlopen(nullptr, RTLD_LAZY)); }
  static Library load(const char* name) {
    void* const loaded = dlopen(name, RTLD_LAZY | RTLD_NOLOAD);
    return loaded ? Library(loaded) : Library(dlopen(name, RTLD_LAZY | RTLD_LOCAL), true);
  }

  /// Whether the program had not loaded it before.
  bool is_new() const { return is_new_; }
  /// Null where there is no such function.
  template <typename Function>
  void find(const char* name, Function*& function) const {
    function = handle_ ? reinterpret_cast<Function*>(dlsym(handle_, name)) : nullptr;
  }

 private:
  explicit Library(void* handle, bool is_new = false) : handle_(handle), is_new_(is_new) {}

  void* handle_;
  bool is_new_;
};

/// Threads are ours: those of the BLAS would be too many, and its sums would depend on their number.
void put_openblas_on_one_thread(const Library& library) {
  int (*get_threads)();
  void (*set_threads)(int);
  library.find("openblas_get_num_threads", get_threads);
  library.find("openblas_set_num_threads", set_threads);
  // To set the number starts them again where they have been ended.
  if (get_threads && set_threads && get_threads() != 1) set_threads(1);
}

/// OpenBLAS starts threads as it is loaded, and lets them spin.
void end_openblas_threads(const Library& library) {
  int (*end_threads)();
  library.find("blas_thread_shutdown_", end_threads);
  if (end_threads) end_threads();
}

/// Whether all that is needed was found.
bool find_routines(const Library& library, Blas& blas) {
  library.find("dpotrf_", blas.potrf);
  library.find("dtrsm_", blas.trsm);
  library.find("dsyrk_", blas.syrk);
  library.find("dgemm_", blas.gemm);
  return blas.potrf && blas.trsm && blas.syrk && blas.gemm;
}

void find_openmp(const Library& library, Blas& blas) {
  library.find("omp_get_max_threads", blas.get_openmp_threads);
  library.find("omp_set_num_threads", blas.set_openmp_threads);
  if (!blas.set_openmp_threads) blas.get_openmp_threads = nullptr;
}

/// Where the routines of `blas` were found.
Library find_lapack(Blas& blas) {
  if (const Library program = Library::of_program(); find_routines(program, blas)) return program;
  std::string reasons;
  for (const char* name : {"libopenblas.so.0", "liblapack.so.3"}) {
    if (const Library library = Library::load(name); find_routines(library, blas)) return library;
    const char* reason = dlerror();
    reasons += std::string("; ") + (reason ? reason : name);
  }
  throw NoLapack("LAPACK cannot be loaded" + reasons);
}

Blas load_blas() {
  Blas found{};
  const Library library = find_lapack(found);
  put_openblas_on_one_thread(library);
  if (library.is_new()) end_openblas_threads(library);
  find_openmp(library, found);
  int (*get_parallel)();
  library.find("openblas_get_parallel", get_parallel);
  found.must_be_alone = get_parallel && get_parallel() == 0;  // OpenBLAS built without threads
  char* (*get_config)();
  library.find("openblas_get_config", get_config);
  found.name = get_config ? get_config() : "LAPACK of the system";
  return found;
}

}  // namespace

const Blas& blas() {
  static const Blas loaded = load_blas();
  return loaded;
}

}  // namespace mapjoin
