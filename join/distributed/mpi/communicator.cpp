// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/distributed/mpi/communicator.hpp>
#include <optional>

namespace mapjoin::distributed {
namespace {

/// MPI counts by int: longer messages go in pieces.
constexpr std::size_t kPiece = std::size_t{1} << 30;
constexpr int kTag = 1;

template <typename F>
void in_pieces(std::size_t size, F&& f) {
  for (std::size_t begin = 0; begin < size; begin += kPiece) f(begin, static_cast<int>(std::min(kPiece, size - begin)));
}

}  // namespace

Communicator::Communicator(MPI_Comm comm) : comm_(comm) {
  MPI_Comm_rank(comm_, &rank_);
  MPI_Comm_size(comm_, &size_);
}

double Communicator::sum(double value) const {
  sum(std::span(&value, 1));
  return value;
}

void Communicator::sum(std::span<double> values) const {
  const auto count = static_cast<int>(values.size());
  MPI_Reduce(is_root() ? MPI_IN_PLACE : values.data(), values.data(), count, MPI_DOUBLE, MPI_SUM, 0, comm_);
  MPI_Bcast(values.data(), count, MPI_DOUBLE, 0, comm_);
}

std::int64_t Communicator::sum(std::int64_t value) const {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_INT64_T, MPI_SUM, comm_);
  return value;
}

double Communicator::max(double value) const {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, comm_);
  return value;
}

std::string Communicator::broadcast(std::string bytes, int from) const {
  std::uint64_t size = bytes.size();
  MPI_Bcast(&size, 1, MPI_UINT64_T, from, comm_);
  bytes.resize(size);
  in_pieces(size, [&](std::size_t begin, int count) { MPI_Bcast(bytes.data() + begin, count, MPI_CHAR, from, comm_); });
  return bytes;
}

std::vector<std::string> Communicator::gather(const std::string& bytes) const {
  std::vector<std::string> all;
  for (int r = 0; r < size_; ++r) all.push_back(broadcast(r == rank_ ? bytes : std::string(), r));
  return all;
}

std::vector<std::string> Communicator::exchange(std::vector<std::string> to) const {
  std::vector<std::uint64_t> out(to.size());
  std::vector<std::uint64_t> in(to.size());
  std::transform(to.begin(), to.end(), out.begin(), [](const std::string& bytes) { return bytes.size(); });
  MPI_Alltoall(out.data(), 1, MPI_UINT64_T, in.data(), 1, MPI_UINT64_T, comm_);
  std::vector<std::string> from(to.size());
  // Each rank sends to one and receives from one in each round, so that little waits at a time.
  for (int round = 0; round < size_; ++round) {
    const auto target = static_cast<std::size_t>((rank_ + round) % size_);
    const auto source = static_cast<std::size_t>((rank_ - round + size_) % size_);
    if (round == 0) {
      from[source] = std::move(to[target]);
      continue;
    }
    from[source].resize(in[source]);
    std::vector<MPI_Request> requests;
    in_pieces(in[source], [&](std::size_t begin, int count) {
      MPI_Irecv(from[source].data() + begin, count, MPI_CHAR, static_cast<int>(source), kTag, comm_, &requests.emplace_back());
    });
    in_pieces(out[target], [&](std::size_t begin, int count) {
      MPI_Isend(to[target].data() + begin, count, MPI_CHAR, static_cast<int>(target), kTag, comm_, &requests.emplace_back());
    });
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    release(to[target]);
  }
  return from;
}

std::vector<std::string> Communicator::collect(std::string bytes) const {
  std::vector<std::string> to(static_cast<std::size_t>(size_));
  to.front() = std::move(bytes);
  return exchange(std::move(to));
}

std::optional<Error> Communicator::first_error(const Error* mine) const {
  if (!any(mine != nullptr)) return std::nullopt;
  const std::string said = mine ? static_cast<char>(mine->kind) + mine->message : std::string();
  const std::vector<std::string> all = gather(said);
  const auto first = std::ranges::find_if(all, [](const std::string& words) { return !words.empty(); });
  return Error{static_cast<ErrorKind>(first->front()), first->substr(1)};
}

}  // namespace mapjoin::distributed
