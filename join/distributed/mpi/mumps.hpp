// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// MUMPS (Amestoy, Duff, L'Excellent & Koster, 2001): factorises a symmetric positive definite matrix that is spread over ranks,
// by all of them.

#include <cstdint>
#include <filesystem>
#include <mapjoin/distributed/mpi/communicator.hpp>
#include <mapjoin/solve/engines/factor_values.hpp>
#include <memory>
#include <span>
#include <vector>

namespace mapjoin::distributed {

struct MumpsOptions {
  std::filesystem::path out_of_core = {};  ///< A folder for factors; empty: they stay in memory.
};

/// The factorisation of A = Σ A_r, whose A_r is that of rank r; its rows are in elimination order. Failures are the same on all
/// ranks: std::bad_alloc if memory is too little; tl::bad_expected_access<Error>, with kCannotWrite, if MUMPS cannot
/// write files of the factor, after which this can only be destroyed, and with kUsage if the name of their folder is too long;
/// otherwise std::runtime_error.
class Mumps {
 public:
  Mumps(const Communicator& comm, const MumpsOptions& options);
  ~Mumps();
  Mumps(const Mumps&) = delete;
  Mumps& operator=(const Mumps&) = delete;

  /// Analyses A, of `size` rows. A_r is dense over `rows` (ascending): its lower triangle, column by column.
  void analyse(std::size_t size, std::span<const std::int32_t> rows);
  /// Memory to factorise A (10⁶ bytes) on the rank that needs most, once analysed.
  double megabytes() const;
  /// Allocates as much disk space as this rank's part of the factor takes there, once analysed: MUMPS may wait for ever if the
  /// disk fills while it works. Throws std::system_error if there is too little. Empty if the factor stays in memory.
  FactorValues room_in_files() const;
  /// Factorises A, given the values of A_r. False if A is not positive definite.
  bool factorise(std::span<double> lower);
  /// Replaces b, which is the same on all ranks, by A⁻¹ b.
  void solve(std::span<double> b);

 private:
  struct Instance;
  /// Runs a job of MUMPS, and returns its status, INFOG(1).
  int call(int job);
  /// Ends the instance, and takes away its files.
  void end();

  const Communicator& comm_;
  std::unique_ptr<Instance> mumps_;
  std::vector<std::int32_t> rows_;  ///< The row of each entry of A_r, from 1 on.
  std::vector<std::int32_t> columns_;
  std::vector<std::int32_t> order_;
};

}  // namespace mapjoin::distributed
