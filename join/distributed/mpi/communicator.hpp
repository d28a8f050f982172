// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The ranks that work together over MPI, and the messages between them. Every function is called by all ranks alike.

#include <mpi.h>

#include <cstdint>
#include <mapjoin/distributed/mpi/message.hpp>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin::distributed {

class Communicator {
 public:
  explicit Communicator(MPI_Comm comm);

  MPI_Comm mpi() const { return comm_; }
  int rank() const { return rank_; }
  int size() const { return size_; }
  bool is_root() const { return rank_ == 0; }

  /// The sum over the ranks, in one order of addition: the same bits on all.
  double sum(double value) const;
  void sum(std::span<double> values) const;
  std::int64_t sum(std::int64_t value) const;
  double max(double value) const;
  bool any(bool value) const { return max(value ? 1.0 : 0.0) > 0.0; }

  /// The bytes of rank `from`, on all ranks.
  std::string broadcast(std::string bytes, int from) const;
  /// The bytes of every rank, by rank, on all ranks.
  std::vector<std::string> gather(const std::string& bytes) const;
  /// Sends `to[r]` to rank r; returns the bytes from each rank.
  std::vector<std::string> exchange(std::vector<std::string> to) const;
  /// The bytes of every rank, by rank, on the first rank; empty strings on the others.
  std::vector<std::string> collect(std::string bytes) const;

  /// The records of all ranks, one list after the other, on all ranks.
  template <typename Record>
  std::vector<Record> gather(const std::vector<Record>& records) const {
    std::vector<Record> all;
    for (const std::string& bytes : gather(Writer().put(records).bytes())) {
      const std::vector<Record> some = Reader(bytes).take<Record>();
      all.insert(all.end(), some.begin(), some.end());
    }
    return all;
  }

  /// The error of the first rank that has one, on all ranks; otherwise each rank's own value.
  template <typename T>
  Expected<T> agree(Expected<T> mine) const {
    const auto first = first_error(mine ? nullptr : &mine.error());
    if (first) return tl::unexpected(*first);
    return mine;
  }

 private:
  std::optional<Error> first_error(const Error* mine) const;

  MPI_Comm comm_;
  int rank_ = 0;
  int size_ = 1;
};

}  // namespace mapjoin::distributed
