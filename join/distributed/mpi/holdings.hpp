// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The numbered things that several ranks or regions hold.

#include <compare>
#include <cstdint>
#include <mapjoin/distributed/mpi/communicator.hpp>
#include <vector>

namespace mapjoin::distributed {

/// A thing of this number, and a rank or a region that holds it.
struct Holding {
  std::int32_t number = 0;
  std::int32_t holder = 0;
  auto operator<=>(const Holding&) const = default;
};
template <typename F>
void fields(Holding& holding, const F& f) {
  f(holding.number);
  f(holding.holder);
}

/// The holdings of numbers that at least two hold, ascending, on all ranks; `mine` are those of this rank, each of them once,
/// of numbers below `count`. Each number is looked after by one rank, so that no rank sees the holdings of all (a distributed
/// directory).
std::vector<Holding> shared_holdings(const Communicator& comm, const std::vector<Holding>& mine, std::size_t count);

}  // namespace mapjoin::distributed
