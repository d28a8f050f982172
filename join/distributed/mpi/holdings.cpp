// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/distributed/mpi/holdings.hpp>

namespace mapjoin::distributed {

std::vector<Holding> shared_holdings(const Communicator& comm, const std::vector<Holding>& mine, std::size_t count) {
  const auto ranks = static_cast<std::size_t>(comm.size());
  std::vector<std::vector<Holding>> to(ranks);
  for (const Holding& own : mine)
    to[static_cast<std::size_t>(own.number) * ranks / std::max<std::size_t>(1, count)].push_back(own);
  std::vector<std::string> messages;
  for (const auto& holdings : to) messages.push_back(Writer().put(holdings).bytes());
  messages = comm.exchange(std::move(messages));

  std::vector<Holding> held;
  for (const std::string& message : messages) {
    const std::vector<Holding> some = Reader(message).take<Holding>();
    held.insert(held.end(), some.begin(), some.end());
  }
  std::ranges::sort(held);
  std::vector<Holding> shared;
  for (std::size_t k = 0; k < held.size(); ++k) {
    const bool as_before = k > 0 && held[k - 1].number == held[k].number;
    const bool as_next = k + 1 < held.size() && held[k + 1].number == held[k].number;
    if (as_before || as_next) shared.push_back(held[k]);
  }
  return comm.gather(shared);  // ascending, as are the numbers that ranks look after
}

}  // namespace mapjoin::distributed
