// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// The number of factors whose places are looked up in a piece of work.
constexpr std::size_t kFactorsPerPiece = 100;
/// The least number of blocks of a part, of variables with each other, and the most parts.
constexpr std::size_t kBlocksPerPart = 1500;
constexpr std::size_t kMostParts = 16;

}  // namespace

NormalEquations::NormalEquations(BlockPattern pattern, std::unique_ptr<SparseSolver> solver, const Ordering& ordering)
    : pattern_(std::move(pattern)), elimination_(pattern_, ordering), offsets_{0}, solver_(std::move(solver)) {
  for (const int dof : pattern_.dofs) offsets_.push_back(offsets_.back() + dof);
  gradient_.setZero(size());
  elimination_.matrix.lay_out();
  parallel_invoke(
      [&] {
        find_value_offsets();
        share_out_factors();
      },
      [&] {
        if (size() > 0) solver_->analyse(matrix());
      });
}

void NormalEquations::find_value_offsets() {
  const BlockLower& H = matrix();
  std::vector<Eigen::Index> row_in_panel;  // for each of H's blocks
  row_in_panel.reserve(H.rows.entries().size());
  for (const Column k : H.columns()) {
    Eigen::Index height = 0;
    for (const Column row : H.rows[k]) row_in_panel.push_back(std::exchange(height, height + H.dof(row)));
  }
  const auto value_offset = [&](Variable a, Variable b) -> std::int64_t {
    if (a == kConstant || b == kConstant) return 0;
    const auto [low, high] = std::minmax({elimination_.column[a], elimination_.column[b]});
    const auto rows = H.rows[low];
    const auto found = std::lower_bound(rows.begin(), rows.end(), high) - rows.begin();
    return H.first_value[low] + row_in_panel[H.rows.first(low) + static_cast<std::size_t>(found)];
  };
  const std::size_t count = pattern_.factors.size();
  std::vector<Lists<std::size_t, std::int64_t>> pieces((count + kFactorsPerPiece - 1) / kFactorsPerPiece);
  parallel_chunks(count, kFactorsPerPiece, [&](std::size_t first, std::size_t last) {
    std::vector<std::int64_t> offsets;
    for (std::size_t f = first; f < last; ++f) {
      offsets.clear();
      const auto variables = pattern_.factors[f];
      for (std::size_t j = 0; j < variables.size(); ++j) {
        for (std::size_t i = 0; i < j; ++i) offsets.push_back(value_offset(variables[i], variables[j]));
      }
      pieces[first / kFactorsPerPiece].push_back(offsets);
    }
  });
  for (const auto& piece : pieces) value_offsets_.append(piece);
}

void NormalEquations::share_out_factors() {
  const IndexRange<Column> columns = matrix().columns();
  std::vector<Column> first_column(pattern_.factors.size(), columns.last);
  Table<Column, std::size_t> blocks(columns.size() + 1);  // number of blocks of the factors that begin at each column
  for (std::size_t f = 0; f < first_column.size(); ++f) {
    const auto variables = pattern_.factors[f];
    for (const Variable v : variables) {
      if (v != kConstant) first_column[f] = std::min(first_column[f], elimination_.column[v]);
    }
    blocks[first_column[f]] += variables.size() * (variables.size() + 1) / 2;
  }
  const std::size_t all_blocks = std::accumulate(blocks.begin(), blocks.end(), std::size_t{0});
  const std::size_t per_part = std::max(kBlocksPerPart, all_blocks / kMostParts + 1);
  Table<Column, std::size_t> part_of(columns.size() + 1);
  parts_.assign(1, {{columns.first, columns.first}, {}});
  for (std::size_t so_far = 0; const Column k : columns) {
    if (so_far >= per_part) {
      parts_.push_back({{k, k}, {}});
      so_far = 0;
    }
    part_of[k] = parts_.size() - 1;
    parts_.back().own.last = k + 1;
    so_far += blocks[k];
  }
  for (std::uint32_t f = 0; f < first_column.size(); ++f) parts_[part_of[first_column[f]]].factors.push_back(f);
}

void NormalEquations::set_zero() {
  std::fill(elimination_.matrix.values.begin(), elimination_.matrix.values.end(), 0.0);
  gradient_.setZero();
}

double NormalEquations::accumulate_factors(const std::function<double(std::size_t, Sink)>& f) {
  std::vector<Sink::Waiting> waiting(parts_.size());
  const double sum = parallel_sum(parts_.size(), 1, [&](std::size_t p) {
    double of_part = 0.0;
    for (const std::uint32_t factor : parts_[p].factors) of_part += f(factor, {*this, factor, parts_[p].own, &waiting[p]});
    return of_part;
  });
  for (const Sink::Waiting& of_part : waiting) {
    const double* values = of_part.values.data();
    for (const auto& [to, rows, columns, stride] : of_part.blocks) {
      Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>(to, rows, columns, Eigen::OuterStride<>(stride)) +=
          Eigen::Map<const Eigen::MatrixXd>(values, rows, columns);
      values += rows * columns;
    }
  }
  return sum;
}

void NormalEquations::add_diagonal(Variable v, const Eigen::MatrixXd& block) {
  elimination_.matrix.panel(elimination_.column[v]).topRows(dof(v)) += block;
}

Eigen::MatrixXd NormalEquations::to_columns(const Eigen::MatrixXd& rows) const {
  Eigen::MatrixXd out(rows.rows(), rows.cols());
  for (const Variable v : variables()) out.middleRows(factor_column(v), dof(v)) = rows.middleRows(offset(v), dof(v));
  return out;
}

Eigen::MatrixXd NormalEquations::to_variables(const Eigen::MatrixXd& rows) const {
  if (rows.size() == 0) return rows;
  Eigen::MatrixXd out(rows.rows(), rows.cols());
  for (const Variable v : variables()) out.middleRows(offset(v), dof(v)) = rows.middleRows(factor_column(v), dof(v));
  return out;
}

double NormalEquations::curvature(const Eigen::VectorXd& v) const {
  const Eigen::VectorXd p = to_columns(v);
  return p.dot(matrix() * p);
}

std::optional<double> NormalEquations::least_curvature(const Eigen::VectorXd& v, const Table<Variable, bool>& is_given) const {
  const BlockLower& H = matrix();
  Eigen::VectorXd w = to_columns(v);
  Table<Column, bool> is_free(H.rows.size());
  std::vector<Eigen::Index> free;
  for (const Column k : H.columns()) {
    is_free[k] = !is_given[elimination_.order[k]];
    if (!is_free[k]) continue;
    for (auto row = H.offsets[k]; row < H.offsets[k + 1]; ++row) {
      free.push_back(row);
      w[row] = 0.0;
    }
  }
  if (free.empty()) return w.dot(H * w);
  const BlockLower H_free = H.principal_submatrix(is_free);
  SparseCholesky cholesky;
  cholesky.analyse(H_free);
  if (!cholesky.factorise(H_free).empty()) return std::nullopt;
  w(free) = -cholesky.solve((H * w)(free));
  return w.dot(H * w);
}

void NormalEquations::damp(double damping) {
  elimination_.matrix.set_diagonal((1.0 + damping) * matrix().diagonal());
}

std::optional<Variable> NormalEquations::factorise(double damping) {
  if (size() == 0) return std::nullopt;
  const Eigen::VectorXd undamped = damping > 0.0 ? matrix().diagonal() : Eigen::VectorXd();
  if (damping > 0.0) damp(damping);
  const auto singular = solver_->factorise(matrix());
  if (damping > 0.0) elimination_.matrix.set_diagonal(undamped);
  if (singular.empty()) return std::nullopt;
  const auto& offsets = matrix().offsets;
  return elimination_.order[Column(std::upper_bound(offsets.begin(), offsets.end(), singular.front()) - offsets.begin() - 1)];
}

Eigen::MatrixXd NormalEquations::null_space(std::size_t most_count) const {
  if (size() == 0) return {};
  SparseCholesky cholesky;
  cholesky.analyse(matrix());
  cholesky.factorise(matrix());
  return to_variables(cholesky.null_space(most_count));
}

Eigen::MatrixXd NormalEquations::solve_columns(const Eigen::MatrixXd& B) const {
  return size() == 0 ? B : to_variables(solver_->solve_columns(to_columns(B)));
}

}  // namespace mapjoin
