// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/distributed/holdings.hpp>

namespace mapjoin::distributed {

std::vector<Holding> shared_holdings(const Communicator& comm, const std::vector<std::int32_t>& mine, std::size_t count) {
  const auto ranks = static_cast<std::size_t>(comm.size());
  std::vector<std::vector<std::int32_t>> to(ranks);
  for (const std::int32_t number : mine)
    to[static_cast<std::size_t>(number) * ranks / std::max<std::size_t>(1, count)].push_back(number);
  std::vector<std::string> messages;
  for (const auto& numbers : to) messages.push_back(Writer().put(numbers).bytes());
  messages = comm.exchange(std::move(messages));

  std::vector<Holding> held;
  for (std::size_t r = 0; r < ranks; ++r) {
    for (const auto number : Reader(messages[r]).take<std::int32_t>()) held.push_back({number, static_cast<std::int32_t>(r)});
  }
  std::ranges::sort(held);
  std::vector<Holding> shared;
  for (std::size_t k = 0; k < held.size(); ++k) {
    const bool as_before = k > 0 && held[k - 1].number == held[k].number;
    const bool as_next = k + 1 < held.size() && held[k + 1].number == held[k].number;
    if (as_before || as_next) shared.push_back(held[k]);
  }
  return comm.gather(shared);  // those who look after lower numbers come first
}

}  // namespace mapjoin::distributed
