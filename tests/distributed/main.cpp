// SPDX-License-Identifier: BSD-3-Clause
// Runs the tests of this folder on all ranks of an MPI job alike; each rank has to find them right.
#include <gtest/gtest.h>
#include <mpi.h>

int main(int argc, char** argv) {
  int threads = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &threads);
  ::testing::InitGoogleTest(&argc, argv);
  const int result = RUN_ALL_TESTS();
  MPI_Finalize();
  return result;
}
