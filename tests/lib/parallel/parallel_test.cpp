// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/parallel/pieces.hpp>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

namespace mapjoin {
namespace {

/// Takes time, for every fourth piece much more than for the others, so that these end first.
void dawdle(std::size_t k) {
  std::this_thread::sleep_for(std::chrono::microseconds(k % 4 == 0 ? 2000 : 50));
}

TEST(Isolated, NoMorePiecesAreUnderWayThanThereAreThreads) {
  constexpr int kThreads = 3;
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, kThreads);
  ASSERT_EQ(most_at_once(), std::size_t{kThreads});
  std::atomic<int> under_way = 0;
  std::atomic<int> most = 0;
  std::atomic<int> done = 0;
  const auto piece = [&](std::size_t) {
    isolated([&] {
      const int now = ++under_way;
      for (int before = most; before < now && !most.compare_exchange_weak(before, now);) continue;
      parallel_for(8, dawdle);
      --under_way;
      ++done;
    });
  };
  // Pieces that come late; a thread that waits in one of the first would begin them if that were not isolated.
  tbb::task_arena(kThreads).execute([&] {
    for (int time = 0; time < 40; ++time) parallel_for(2, [&](std::size_t k) { parallel_for(k == 0 ? 1 : 6, piece); });
  });
  EXPECT_LE(most, kThreads);
  EXPECT_EQ(done, 40 * 7);
}

TEST(ParallelInOrder, TakesEachOnceAndInOrderAfterItsWork) {
  constexpr std::size_t kCount = 60;
  std::vector<int> worked(kCount, 0);
  std::vector<std::size_t> taken;
  parallel_in_order(
      kCount, 8,
      [&](std::size_t k) {
        dawdle(k);
        ++worked[k];
      },
      [&](std::size_t k) {
        EXPECT_EQ(worked[k], 1);
        taken.push_back(k);
        return true;
      });
  std::vector<std::size_t> all(kCount);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(taken, all);
}

TEST(ParallelInOrder, IsNoFurtherAheadThanAllowed) {
  constexpr std::size_t kAhead = 3;
  std::atomic<std::size_t> taken = 0;
  std::atomic<bool> too_far = false;
  parallel_in_order(
      40, kAhead,
      [&](std::size_t k) {
        if (k >= taken + kAhead) too_far = true;
        dawdle(k);
      },
      [&](std::size_t) {
        ++taken;
        return true;
      });
  EXPECT_FALSE(too_far);
  EXPECT_EQ(taken, 40U);
}

TEST(ParallelInOrder, EndsWhereOneSaysSo) {
  std::vector<std::size_t> taken;
  std::atomic<std::size_t> worked = 0;
  parallel_in_order(
      1000, 4, [&](std::size_t) { ++worked; },
      [&](std::size_t k) {
        taken.push_back(k);
        return k < 2;
      });
  EXPECT_EQ(taken, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_LE(worked, 3U + 4U);
}

TEST(ParallelInOrder, OfNothingDoesNothing) {
  const auto never = [](std::size_t) { ADD_FAILURE(); };
  parallel_in_order(0, 4, never, [](std::size_t) { return false; });
}

TEST(ParallelInOrder, ThrowsWhatIsThrown) {
  const auto thrown = [](std::size_t k) {
    if (k == 5) throw std::runtime_error("five");
  };
  EXPECT_THROW(parallel_in_order(10, 4, thrown, [](std::size_t) { return true; }), std::runtime_error);
  EXPECT_THROW(parallel_in_order(
                   10, 4, [](std::size_t) {}, [&](std::size_t k) { return thrown(k), true; }),
               std::runtime_error);
}

}  // namespace
}  // namespace mapjoin
