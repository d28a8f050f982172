// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <cstdlib>
#include <mapjoin/solve/heap.hpp>
#ifdef __GLIBC__  // known by now
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

namespace mapjoin {
namespace {

constexpr int kMegabyte = 1 << 20;

void keep_freed_memory() {
  ::mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);
  ::mallopt(M_TRIM_THRESHOLD, 256 * kMegabyte);
}

std::byte* end_of_heap() {
  return static_cast<std::byte*>(::sbrk(0));
}

/// Makes malloc extend the heap once by so much that the kernel can be advised of all of it; what is asked for must be below
/// the threshold of mmap. Where that is refused, malloc goes on without.
void begin_on_large_pages() {
  ::mallopt(M_TOP_PAD, 128 * kMegabyte);
  std::byte* const begin = end_of_heap();
  void* volatile more_than_there_is = std::malloc(kMegabyte);  // volatile: else the compiler leaves both calls out
  std::free(more_than_there_is);
  ::madvise(begin, static_cast<std::size_t>(end_of_heap() - begin), MADV_HUGEPAGE);
  ::mallopt(M_TOP_PAD, 4 * kMegabyte);
}

}  // namespace

void prepare_heap() {
  keep_freed_memory();
  begin_on_large_pages();
}

}  // namespace mapjoin
#else
void mapjoin::prepare_heap() {}
#endif
