// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// MUMPS (Amestoy, Duff, L'Excellent & Koster, 2001): a symmetric positive definite matrix that is spread over ranks, factorised
// by all of them.

#include <cstdint>
#include <filesystem>
#include <mapjoin/distributed/mpi/communicator.hpp>
#include <memory>
#include <span>
#include <vector>

namespace mapjoin::distributed {

struct MumpsOptions {
  std::filesystem::path out_of_core = {};  ///< A folder for factors; empty: they stay in memory.
};

/// A = Σ A_r, of which rank r has A_r. Its rows are in the order of their elimination. What MUMPS cannot do is
/// std::runtime_error, too little memory std::bad_alloc, on all ranks.
class Mumps {
 public:
  Mumps(const Communicator& comm, const MumpsOptions& options);
  ~Mumps();
  Mumps(const Mumps&) = delete;
  Mumps& operator=(const Mumps&) = delete;

  /// A_r is dense over these rows, which ascend: its lower triangle, column by column. `size` is that of A.
  void analyse(std::size_t size, std::span<const std::int32_t> rows);
  /// What the rank that needs most needs to factorise A (10⁶ bytes), once analysed.
  double megabytes() const;
  /// False where A is not positive definite.
  bool factorise(std::span<double> lower);
  /// A⁻¹ b in the place of b, which is the same on all ranks.
  void solve(std::span<double> b);

 private:
  struct Instance;
  /// Lets MUMPS do a job, and returns its status, INFOG(1).
  int call(int job);

  const Communicator& comm_;
  std::unique_ptr<Instance> mumps_;
  std::vector<std::int32_t> rows_;  ///< Of each entry of A_r, from 1 on.
  std::vector<std::int32_t> columns_;
  std::vector<std::int32_t> order_;
};

}  // namespace mapjoin::distributed
