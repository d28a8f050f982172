// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/distributed/mpi/communicator.hpp>
#include <mapjoin/distributed/mpi/holdings.hpp>

namespace mapjoin::distributed {
namespace {

class Ranks : public ::testing::Test {
 protected:
  Communicator comm{MPI_COMM_WORLD};
  int rank = comm.rank();
  int size = comm.size();
};

TEST_F(Ranks, AddUpWhatEachHas) {
  EXPECT_EQ(comm.sum(static_cast<double>(rank + 1)), size * (size + 1) / 2);
  EXPECT_EQ(comm.sum(std::int64_t{1} << 40), std::int64_t{size} << 40);
  EXPECT_EQ(comm.max(rank), size - 1);
  EXPECT_TRUE(comm.any(rank == size - 1));
  EXPECT_FALSE(comm.any(false));
}

TEST_F(Ranks, GatherListsInTheirOrder) {
  const std::vector<std::int32_t> mine(static_cast<std::size_t>(rank), rank);
  std::vector<std::int32_t> expected;
  for (int r = 0; r < size; ++r) expected.insert(expected.end(), static_cast<std::size_t>(r), r);
  EXPECT_EQ(comm.gather(mine), expected);
}

TEST_F(Ranks, ExchangeALetterWithEach) {
  const auto letter = [](int from, int to) { return std::string(static_cast<std::size_t>(1000 * from + to), 'x'); };
  std::vector<std::string> to;
  for (int r = 0; r < size; ++r) to.push_back(letter(rank, r));
  const std::vector<std::string> from = comm.exchange(to);
  for (int r = 0; r < size; ++r) EXPECT_EQ(from[static_cast<std::size_t>(r)], letter(r, rank));
}

TEST_F(Ranks, AgreeOnTheErrorOfTheFirst) {
  using Result = Expected<int>;
  EXPECT_EQ(comm.agree(Result(rank)).value(), rank);
  const Result failed = rank == 0 && size > 1 ? Result(1) : tl::unexpected(Error{ErrorKind::kTooLarge, std::to_string(rank)});
  const Result agreed = comm.agree(failed);
  ASSERT_FALSE(agreed);
  EXPECT_EQ(agreed.error().kind, ErrorKind::kTooLarge);
  EXPECT_EQ(agreed.error().message, size > 1 ? "1" : "0");
}

TEST_F(Ranks, KnowWhatSeveralHold) {
  // Rank r holds r and r + 1, and all hold 100.
  const std::vector<Holding> shared = shared_holdings(comm, {{rank, rank}, {rank + 1, rank}, {100, rank}}, 101);
  std::vector<Holding> expected;
  for (int r = 1; r < size; ++r) expected.insert(expected.end(), {{r, r - 1}, {r, r}});
  for (int r = 0; r < size && size > 1; ++r) expected.push_back({100, r});
  EXPECT_EQ(shared, expected);
}

}  // namespace
}  // namespace mapjoin::distributed
