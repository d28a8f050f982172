// SPDX-License-Identifier: BSD-3-Clause
// Each in a process of its own, as ctest runs them: what is done to the heap stays.

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <mapjoin/solve/heap.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace mapjoin {
namespace {

constexpr std::size_t kMegabyte = 1 << 20;

const std::byte* end_of_heap() {
  return static_cast<const std::byte*>(::sbrk(0));
}

/// The heap begins behind the program's data.
bool is_on_heap(const void* memory) {
  static char in_data = 0;
  return memory > &in_data && memory < end_of_heap();
}

/// A sanitizer's malloc has no heap to prepare.
bool is_malloc_of_sanitizer() {
  const std::vector<double> some(1000);
  return !is_on_heap(some.data());
}

/// What /proc/self/smaps says of the mapping that holds an address.
std::string flags_of_mapping(const void* address) {
  std::ifstream smaps("/proc/self/smaps");
  bool is_there = false;
  for (std::string line; std::getline(smaps, line);) {
    std::istringstream words(line);
    std::uintptr_t begin = 0;
    std::uintptr_t end = 0;
    char dash = '\0';
    if (words >> std::hex >> begin >> dash >> end && dash == '-') {
      is_there = begin <= reinterpret_cast<std::uintptr_t>(address) && reinterpret_cast<std::uintptr_t>(address) < end;
    } else if (is_there && line.starts_with("VmFlags:")) {
      return line;
    }
  }
  return "";
}

/// Data of this process (bytes), as RLIMIT_DATA counts it.
std::size_t data_size() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::size_t kilobytes = 0;
    if (word == "VmData:" && status >> kilobytes) return kilobytes << 10;
  }
  return 0;
}

TEST(Heap, BeginsOnLargePages) {
  if (is_malloc_of_sanitizer()) GTEST_SKIP() << "another malloc";
  if (!std::filesystem::exists("/sys/kernel/mm/transparent_hugepage")) GTEST_SKIP() << "a kernel without large pages";
  prepare_heap();
  const std::vector<double> some(8 * kMegabyte / sizeof(double));
  ASSERT_TRUE(is_on_heap(some.data()));
  const std::string flags = flags_of_mapping(&some.back());
  EXPECT_NE(flags.find(" hg"), std::string::npos) << flags;
}

/// Else what malloc gives first is on small pages: where one of these is touched, no large one will be.
TEST(Heap, FirstLargePageIsNearAndUntouched) {
  if (is_malloc_of_sanitizer()) GTEST_SKIP() << "another malloc";
  prepare_heap();
  auto* const block = static_cast<std::byte*>(std::malloc(kMegabyte / 5));
  ASSERT_TRUE(is_on_heap(block));
  const std::size_t large_page = 2 * kMegabyte;
  const std::size_t before = large_page - reinterpret_cast<std::uintptr_t>(block) % large_page;
  EXPECT_LE(before, kMegabyte / 4);
  std::vector<unsigned char> is_touched(large_page / 4096);
  ASSERT_EQ(::mincore(block + before, large_page, is_touched.data()), 0);
  std::free(block);
  EXPECT_EQ(std::count_if(is_touched.begin(), is_touched.end(), [](unsigned char page) { return (page & 1U) != 0; }), 0);
}

/// Of a program that has worked before.
TEST(Heap, IsExtendedWhateverIsFree) {
  if (is_malloc_of_sanitizer()) GTEST_SKIP() << "another malloc";
  std::vector<std::vector<std::byte>> freed(80, std::vector<std::byte>(kMegabyte / 10));
  const std::vector<std::byte> above(kMegabyte / 9);
  freed.clear();
  ASSERT_TRUE(is_on_heap(above.data()));
  const std::byte* const end = end_of_heap();
  prepare_heap();
  EXPECT_GT(end_of_heap() - end, static_cast<std::ptrdiff_t>(128 * kMegabyte));
}

TEST(Heap, KeepsWhatIsFreed) {
  if (is_malloc_of_sanitizer()) GTEST_SKIP() << "another malloc";
  prepare_heap();
  std::vector<std::vector<std::byte>> blocks(200, std::vector<std::byte>(kMegabyte));
  ASSERT_TRUE(is_on_heap(blocks.back().data()));
  const std::byte* const end = end_of_heap();
  blocks.clear();
  EXPECT_EQ(end_of_heap(), end);
}

TEST(Heap, IsWhatItWasWhereMemoryIsShort) {
  ::rlimit limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_DATA, &limit), 0);
  limit.rlim_cur = data_size() + 64 * kMegabyte;
  ASSERT_EQ(::setrlimit(RLIMIT_DATA, &limit), 0);
  prepare_heap();
  EXPECT_NO_THROW(std::vector<double>(16 * kMegabyte / sizeof(double)));
}

}  // namespace
}  // namespace mapjoin
