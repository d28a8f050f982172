// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <mapjoin/solve/heap.hpp>
#ifdef __GLIBC__  // known by now
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

namespace mapjoin {
namespace {

constexpr int kMegabyte = 1 << 20;
constexpr int kLargePage = 2 * kMegabyte;
constexpr int kMoreThanThereIs = kMegabyte / 4;  // free, where a program begins

void keep_freed_memory() {
  ::mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);
  ::mallopt(M_TRIM_THRESHOLD, 256 * kMegabyte);
}

std::byte* end_of_heap() {
  return static_cast<std::byte*>(::sbrk(0));
}

/// Leaves out so much of the address space that a large page begins `room` bytes behind the end of the heap.
void move_end_of_heap_before_large_page(int room) {
  const auto past =
      static_cast<int>((reinterpret_cast<std::uintptr_t>(end_of_heap()) + static_cast<std::uintptr_t>(room)) % kLargePage);
  ::sbrk(kLargePage - past);
}

/// Makes malloc extend the heap once by so much that the kernel can be advised of all of it, and before any of its large pages
/// is touched: the block that it is extended for ends below them. Where that is refused, malloc goes on without.
void begin_on_large_pages() {
  move_end_of_heap_before_large_page(kMoreThanThereIs + 4096);  // malloc's own words around the block
  ::mallopt(M_TOP_PAD, 128 * kMegabyte);
  std::byte* const begin = end_of_heap();
  void* volatile block = std::malloc(kMoreThanThereIs);  // volatile: else the compiler leaves both calls out
  std::free(block);
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
