// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/distributed/regions/region_solver.hpp>
#include <system_error>

namespace mapjoin::distributed {

RegionSolver::RegionSolver(const Communicator& comm, const OuterUnknowns& outer, std::size_t outer_blocks,
                           const MumpsOptions& options)
    : comm_(comm),
      outer_(outer),
      cholesky_(outer_blocks, options.out_of_core),
      mumps_(std::make_unique<Mumps>(comm, options)),
      is_in_file_(!options.out_of_core.empty()) {}

Expected<void> RegionSolver::make_room() {
  FactorValues of_mumps;  // until every rank has seen that there is room for all
  const auto made = [&]() -> Expected<void> {
    try {
      cholesky_.make_room();
      if (outer_.size > 0) of_mumps = mumps_->room_in_files();
      return {};
    } catch (const std::system_error& failure) {
      return tl::unexpected(Error{ErrorKind::kCannotWrite, failure.what()});
    }
  };
  return comm_.agree(made());
}

void RegionSolver::analyse(const BlockLower& matrix, std::span<const GivenFront> given) {
  cholesky_.analyse(matrix, given);
  if (outer_.size > 0) mumps_->analyse(outer_.size, outer_.unknowns);
}

std::vector<std::int64_t> RegionSolver::factorise(const BlockLower& matrix, std::span<const GivenFront> given) {
  auto singular = cholesky_.factorise(matrix, given);
  is_singular_here_ = !singular.empty();
  bool is_singular = comm_.any(is_singular_here_);
  if (!is_singular && outer_.size > 0) {
    const ConstDenseBlock S = cholesky_.schur_complement();
    std::vector<double> lower;
    lower.reserve(static_cast<std::size_t>(S.rows() * (S.rows() + 1) / 2));
    for (Eigen::Index j = 0; j < S.cols(); ++j) lower.insert(lower.end(), S.col(j).data() + j, S.col(j).data() + S.rows());
    is_singular = !mumps_->factorise(lower);
  }
  if (is_singular && singular.empty()) singular.push_back(matrix.size() - 1);
  return singular;
}

Eigen::MatrixXd RegionSolver::solve_columns(Eigen::MatrixXd B) const {
  B = cholesky_.solve_lower(std::move(B));
  const std::vector<std::int32_t>& unknowns = outer_.unknowns;
  const Eigen::Index first = B.rows() - static_cast<Eigen::Index>(unknowns.size());
  for (Eigen::Index column = 0; column < B.cols() && outer_.size > 0; ++column) {
    std::vector<double> shared(outer_.size, 0.0);
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      shared[static_cast<std::size_t>(unknowns[k])] = B(first + static_cast<Eigen::Index>(k), column);
    }
    comm_.sum(shared);
    mumps_->solve(shared);
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      B(first + static_cast<Eigen::Index>(k), column) = shared[static_cast<std::size_t>(unknowns[k])];
    }
  }
  return cholesky_.solve_upper(std::move(B));
}

}  // namespace mapjoin::distributed
