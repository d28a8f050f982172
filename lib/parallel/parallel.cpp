// SPDX-License-Identifier: BSD-3-Clause
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <mapjoin/parallel/parallel.hpp>

#ifdef MAPJOIN_TELL_TSAN
#include <sanitizer/tsan_interface.h>
#endif

namespace mapjoin {
namespace {

#ifdef MAPJOIN_TELL_TSAN

/// TBB's library is not compiled with the thread sanitizer, which so does not see how TBB hands work over and waits for it.
/// This tells it: every piece comes after what was before the call and before what follows. The pieces stay unordered among
/// themselves. This file, and with it TBB's headers, is not instrumented either.
class HandOver {
 public:
  HandOver() { __tsan_release(&begin_); }
  ~HandOver() { __tsan_acquire(&end_); }
  HandOver(const HandOver&) = delete;
  HandOver& operator=(const HandOver&) = delete;

  class Piece {
   public:
    explicit Piece(HandOver& whole) : whole_(whole) { __tsan_acquire(&whole_.begin_); }
    ~Piece() { __tsan_release(&whole_.end_); }
    Piece(const Piece&) = delete;
    Piece& operator=(const Piece&) = delete;

   private:
    HandOver& whole_;
  };

 private:
  char begin_ = 0;
  char end_ = 0;
};

#else

struct HandOver {
  struct Piece {
    explicit Piece(HandOver&) {}
  };
};

#endif

}  // namespace

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& f) {
  if (count == 1) return f(0);
  HandOver whole;
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t k) {
    const HandOver::Piece piece(whole);
    f(k);
  });
}

void parallel_invoke(const std::function<void()>& f, const std::function<void()>& g) {
  HandOver whole;
  const auto piece_of = [&whole](const std::function<void()>& h) {
    const HandOver::Piece piece(whole);
    h();
  };
  tbb::parallel_invoke([&] { piece_of(f); }, [&] { piece_of(g); });
}

}  // namespace mapjoin
