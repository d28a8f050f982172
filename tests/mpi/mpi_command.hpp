// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// `mpirun -n N mapjoin-mpi` as the tests call it.

#include <cstdlib>
#include <sstream>
#include <string>
#include <tests/support/process.hpp>
#include <utility>
#include <vector>

namespace mapjoin::testing {

inline std::vector<std::string> mpi_command_line(int ranks, const std::vector<std::string>& arguments) {
  ::setenv("OPENBLAS_NUM_THREADS", "1", 1);
  std::vector<std::string> words;
  std::istringstream mpirun(MAPJOIN_MPIRUN);
  for (std::string word; mpirun >> word;) words.push_back(word);
  words.insert(words.end(), {"-n", std::to_string(ranks), MAPJOIN_MPI_COMMAND});
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

}  // namespace mapjoin::testing
