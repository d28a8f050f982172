// SPDX-License-Identifier: BSD-3-Clause
#include <dmumps_c.h>
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <mapjoin/distributed/mpi/mumps.hpp>
#include <mapjoin/model/error.hpp>
#include <new>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace mapjoin::distributed {
namespace {

// Jobs and statuses by their numbers in MUMPS's manual.
constexpr int kBegin = -1;
constexpr int kEnd = -2;
constexpr int kAnalyse = 1;
constexpr int kFactorise = 2;
constexpr int kSolve = 3;
constexpr int kSymmetricPositiveDefinite = 1;
constexpr int kHostWorks = 1;

constexpr int kTooLittleIntegerSpace = -8;
constexpr int kTooLittleRealSpace = -9;
constexpr int kSingular = -10;
constexpr int kTooLittleMemory = -13;
constexpr int kNotPositive = -40;
constexpr int kFilesFailed = -90;

[[noreturn]] void fail(ErrorKind kind, std::string message) {
  throw tl::bad_expected_access<Error>(Error{kind, std::move(message)});
}

/// Maximum room beyond the estimate of the analysis that is tried (%).
constexpr int kMostRoom = 1000;

}  // namespace

struct Mumps::Instance : DMUMPS_STRUC_C {
  /// Entries of the manual's arrays, which count from 1.
  MUMPS_INT& control(int k) { return icntl[k - 1]; }
  MUMPS_INT info(int k) const { return infog[k - 1]; }
  MUMPS_INT info_of_rank(int k) const { return DMUMPS_STRUC_C::info[k - 1]; }
  bool is_out_of_core() { return control(22) == 1; }
};

Mumps::Mumps(const Communicator& comm, const MumpsOptions& options) : comm_(comm), mumps_(std::make_unique<Instance>()) {
  mumps_->comm_fortran = static_cast<MUMPS_INT>(MPI_Comm_c2f(comm.mpi()));
  mumps_->sym = kSymmetricPositiveDefinite;
  mumps_->par = kHostWorks;
  call(kBegin);
  for (const int stream : {1, 2, 3}) mumps_->control(stream) = -1;  // no messages
  mumps_->control(4) = 0;
  mumps_->control(7) = 1;   // the order is given
  mumps_->control(13) = 1;  // negative pivots are counted everywhere
  mumps_->control(18) = 3;  // each rank has entries of its own
  mumps_->control(28) = 1;  // analysed on the first rank
  if (options.out_of_core.empty()) return;
  const std::string folder = options.out_of_core.string();
  if (folder.size() >= sizeof mumps_->ooc_tmpdir) fail(ErrorKind::kUsage, folder + ": the name is too long for --out-of-core");
  mumps_->control(22) = 1;
  folder.copy(mumps_->ooc_tmpdir, folder.size());
  mumps_->ooc_tmpdir[folder.size()] = '\0';
}

Mumps::~Mumps() {
  if (!mumps_ || std::uncaught_exceptions() > 0) return;  // the other ranks may not come here
  end();
}

void Mumps::end() {
  mumps_->job = kEnd;
  dmumps_c(mumps_.get());
  mumps_.reset();
}

int Mumps::call(int job) {
  mumps_->job = job;
  dmumps_c(mumps_.get());
  const int status = mumps_->info(1);
  if (status == kTooLittleMemory) throw std::bad_alloc();
  if (status == kFilesFailed) {
    const std::string folder = mumps_->ooc_tmpdir;
    end();  // and with it its files
    fail(ErrorKind::kCannotWrite, folder +
                                      ": the files of the factor could not be written or read there, as on a full disk; "
                                      "--out-of-core takes a folder with more room");
  }
  const bool is_known = status >= 0 || status == kTooLittleIntegerSpace || status == kTooLittleRealSpace ||
                        status == kSingular || status == kNotPositive;
  if (!is_known) throw std::runtime_error(fmt::format("MUMPS ended job {} with status {} ({})", job, status, mumps_->info(2)));
  return status;
}

void Mumps::analyse(std::size_t size, std::span<const std::int32_t> rows) {
  rows_.clear();
  columns_.clear();
  for (std::size_t j = 0; j < rows.size(); ++j) {
    for (std::size_t i = j; i < rows.size(); ++i) {
      rows_.push_back(rows[i] + 1);
      columns_.push_back(rows[j] + 1);
    }
  }
  order_.resize(size);
  std::iota(order_.begin(), order_.end(), 1);
  mumps_->n = static_cast<MUMPS_INT>(size);
  mumps_->nnz_loc = static_cast<MUMPS_INT8>(rows_.size());
  mumps_->irn_loc = rows_.data();
  mumps_->jcn_loc = columns_.data();
  mumps_->perm_in = order_.data();
  call(kAnalyse);
}

double Mumps::megabytes() const {
  return static_cast<double>(mumps_->info(mumps_->is_out_of_core() ? 26 : 16));
}

FactorValues Mumps::room_in_files() const {
  if (!mumps_->is_out_of_core()) return {};
  constexpr std::int64_t kMillion = 1'000'000;
  const std::int64_t entries = mumps_->info_of_rank(3);  // negative: in millions
  return FactorValues(static_cast<std::size_t>(entries < 0 ? -entries * kMillion : entries), mumps_->ooc_tmpdir);
}

bool Mumps::factorise(std::span<double> lower) {
  mumps_->a_loc = lower.data();
  int status = call(kFactorise);
  for (int room = 50; (status == kTooLittleIntegerSpace || status == kTooLittleRealSpace) && room <= kMostRoom; room *= 2) {
    mumps_->control(14) = room;
    status = call(kFactorise);
  }
  mumps_->a_loc = nullptr;
  if (status == kTooLittleIntegerSpace || status == kTooLittleRealSpace) throw std::bad_alloc();
  return status >= 0 && mumps_->info(12) == 0;
}

void Mumps::solve(std::span<double> b) {
  mumps_->rhs = b.data();
  mumps_->nrhs = 1;
  mumps_->lrhs = static_cast<MUMPS_INT>(b.size());
  call(kSolve);
  MPI_Bcast(b.data(), static_cast<int>(b.size()), MPI_DOUBLE, 0, comm_.mpi());
}

}  // namespace mapjoin::distributed
