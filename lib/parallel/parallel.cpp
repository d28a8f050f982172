// SPDX-License-Identifier: BSD-3-Clause
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/parallel/pieces.hpp>

#ifdef MAPJOIN_TELL_TSAN
#include <sanitizer/tsan_interface.h>
#endif

namespace mapjoin {
namespace {

#ifdef MAPJOIN_TELL_TSAN

/// The order of work, told to the thread sanitizer, which cannot see it in TBB: that library is not instrumented. Every piece
/// comes after what was before the call and before what follows; every step comes also after the pieces and steps that have
/// ended. The pieces stay unordered among themselves. This file, and with it TBB's headers, is not instrumented either.
class HandOver {
 public:
  HandOver() { __tsan_release(&begin_); }
  ~HandOver() { __tsan_acquire(&end_); }
  HandOver(const HandOver&) = delete;
  HandOver& operator=(const HandOver&) = delete;

  class Part {
   public:
    Part(char& after, char& before) : before_(before) { __tsan_acquire(&after); }
    ~Part() { __tsan_release(&before_); }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

   private:
    char& before_;
  };
  Part piece() { return {begin_, end_}; }
  Part step() { return {end_, end_}; }

 private:
  char begin_ = 0;
  char end_ = 0;
};

#else

struct HandOver {
  struct Part {};
  Part piece() { return {}; }
  Part step() { return {}; }
};

#endif

}  // namespace

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& f) {
  if (count == 1) return f(0);
  HandOver whole;
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t k) {
    [[maybe_unused]] const auto piece = whole.piece();
    f(k);
  });
}

void parallel_invoke(const std::function<void()>& f, const std::function<void()>& g) {
  HandOver whole;
  const auto piece_of = [&whole](const std::function<void()>& h) {
    [[maybe_unused]] const auto piece = whole.piece();
    h();
  };
  tbb::parallel_invoke([&] { piece_of(f); }, [&] { piece_of(g); });
}

void parallel_in_order(std::size_t count, std::size_t at_once, const std::function<void(std::size_t)>& f,
                       const std::function<bool(std::size_t)>& g) {
  HandOver whole;
  std::size_t next = 0;
  std::atomic<bool> goes_on = true;
  const auto begin = [&](tbb::flow_control& control) {
    if (next == count || !goes_on) control.stop();
    return next++;
  };
  const auto work = [&](std::size_t k) {
    [[maybe_unused]] const auto piece = whole.piece();
    f(k);
    return k;
  };
  const auto finish = [&](std::size_t k) {
    [[maybe_unused]] const auto step = whole.step();
    if (goes_on) goes_on = g(k);
  };
  tbb::parallel_pipeline(at_once, tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, begin) &
                                      tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, work) &
                                      tbb::make_filter<std::size_t, void>(tbb::filter_mode::serial_in_order, finish));
}

void isolated(const std::function<void()>& f) {
  tbb::this_task_arena::isolate([&] { f(); });
}

std::size_t most_at_once() {
  return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
}

}  // namespace mapjoin
