// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <mapjoin/distributed/mpi/mumps.hpp>
#include <numeric>
#include <system_error>
#include <tests/support/random.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::distributed {
namespace {

/// A chain of dense matrices, one for each rank, each of which shares half of its rows with the next.
class ChainOfMatrices : public ::testing::Test {
 protected:
  static constexpr int kRows = 20;

  ChainOfMatrices() {
    testing::Random random;
    for (int r = 0; r < comm.size(); ++r) {
      Eigen::MatrixXd J(kRows, kRows);
      for (auto& entry : J.reshaped()) entry = random.uniform(-1.0, 1.0);
      const Eigen::MatrixXd part = J * J.transpose() + Eigen::MatrixXd::Identity(kRows, kRows);
      A.block(r * kRows / 2, r * kRows / 2, kRows, kRows) += part;
      if (r == comm.rank()) mine = part;
    }
    for (int k = 0; k < kRows; ++k) rows.push_back(comm.rank() * kRows / 2 + k);
  }

  std::vector<double> lower() const {
    std::vector<double> values;
    for (int j = 0; j < kRows; ++j) values.insert(values.end(), mine.col(j).data() + j, mine.col(j).data() + kRows);
    return values;
  }
  void expect_solved(Mumps& mumps) const {
    Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(A.rows(), -1.0, 2.0);
    const Eigen::VectorXd x = A.llt().solve(b);
    mumps.solve(std::span(b.data(), static_cast<std::size_t>(b.size())));
    EXPECT_LT((b - x).norm(), 1e-12 * x.norm());
  }

  Communicator comm{MPI_COMM_WORLD};
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero((comm.size() + 1) * kRows / 2, (comm.size() + 1) * kRows / 2);
  Eigen::MatrixXd mine;
  std::vector<std::int32_t> rows;
};

TEST_F(ChainOfMatrices, IsSolvedLikeTheDenseSum) {
  Mumps mumps(comm, {});
  mumps.analyse(static_cast<std::size_t>(A.rows()), rows);
  auto values = lower();
  ASSERT_TRUE(mumps.factorise(values));
  expect_solved(mumps);
  values = lower();
  ASSERT_TRUE(mumps.factorise(values));  // a second time after one analysis
  expect_solved(mumps);
}

TEST_F(ChainOfMatrices, IsSolvedWithItsFactorInFiles) {
  const testing::TemporaryFolder folder;
  Mumps mumps(comm, {folder.path()});
  mumps.analyse(static_cast<std::size_t>(A.rows()), rows);
  auto values = lower();
  ASSERT_TRUE(mumps.factorise(values));
  expect_solved(mumps);
}

TEST_F(ChainOfMatrices, SaysThatItsFilesCannotBeWritten) {
  const testing::TemporaryFolder folder;
  const std::filesystem::path gone = folder.path() / "gone";
  Mumps mumps(comm, {gone});
  mumps.analyse(static_cast<std::size_t>(A.rows()), rows);
  auto values = lower();
  try {
    (void)mumps.factorise(values);
    FAIL() << "nothing was refused";
  } catch (const tl::bad_expected_access<Error>& failure) {
    EXPECT_EQ(failure.error().kind, ErrorKind::kCannotWrite);
    EXPECT_EQ(failure.error().message, gone.string() +
                                           ": the files of the factor could not be written or read there, as on a full disk; "
                                           "--out-of-core takes a folder with more room");
  }
}

TEST_F(ChainOfMatrices, SeesBeforeTheWorkWhetherThereIsRoomForItsFiles) {
  const auto has_no_room = [&](const std::filesystem::path& folder) {
    Mumps mumps(comm, {folder});
    mumps.analyse(static_cast<std::size_t>(A.rows()), rows);
    bool is_refused = false;
    try {
      (void)mumps.room_in_files();
    } catch (const std::system_error&) {
      is_refused = true;
    }
    return comm.any(is_refused);  // a rank may have none of the factor
  };
  EXPECT_TRUE(has_no_room("/proc"));
  EXPECT_FALSE(has_no_room(testing::TemporaryFolder().path()));
  EXPECT_FALSE(has_no_room(""));
}

TEST_F(ChainOfMatrices, IsSaidNotToBePositiveDefinite) {
  Mumps mumps(comm, {});
  mumps.analyse(static_cast<std::size_t>(A.rows()), rows);
  mine -= 100.0 * Eigen::MatrixXd::Identity(kRows, kRows);
  auto values = lower();
  EXPECT_FALSE(mumps.factorise(values));
}

TEST(Mumps, SaysWhatItWillTakeBeforeItTakesIt) {
  const Communicator comm(MPI_COMM_WORLD);
  constexpr std::int32_t kRows = 1500;
  std::vector<std::int32_t> rows(kRows);
  std::iota(rows.begin(), rows.end(), 0);
  Mumps mumps(comm, {});
  mumps.analyse(kRows, rows);
  const double triangle = 8.0 * kRows * kRows / 2.0 / 1e6;
  EXPECT_GT(mumps.megabytes(), 0.9 * triangle / comm.size());
  EXPECT_LT(mumps.megabytes(), 10.0 * triangle + 50.0);
}

}  // namespace
}  // namespace mapjoin::distributed
