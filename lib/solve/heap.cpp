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
constexpr std::uintptr_t kLargePage = 2 << 20;
/// malloc's own words around a block, and more.
constexpr std::size_t kWords = 4096;

void keep_freed_memory() {
  ::mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);
  ::mallopt(M_TRIM_THRESHOLD, 256 * kMegabyte);
}

std::byte* end_of_heap() {
  return static_cast<std::byte*>(::sbrk(0));
}

/// Room for a block that is larger than all that is free, in whole pages of any size.
std::size_t more_than_is_free() {
  constexpr std::size_t kStep = kMegabyte / 4;
  return (::mallinfo2().fordblks + kWords) / kStep * kStep + kStep;
}

/// Leaves out so much of the address space that a large page begins `room` bytes behind the end of the heap.
void move_end_of_heap_before_large_page(std::size_t room) {
  const std::uintptr_t end = reinterpret_cast<std::uintptr_t>(end_of_heap()) + room;
  ::sbrk(static_cast<std::intptr_t>(-end % kLargePage));
}

/// Makes malloc extend the heap once by so much that the kernel can be advised of all of it, and before any of its large pages
/// is touched: the block that it is extended for ends below them. Where that is refused, malloc goes on without.
void begin_on_large_pages() {
  const std::size_t room = more_than_is_free();
  move_end_of_heap_before_large_page(room);
  ::mallopt(M_TOP_PAD, 128 * kMegabyte);
  std::byte* const begin = end_of_heap();
  void* volatile block = std::malloc(room - kWords);  // volatile: else the compiler leaves both calls out
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
