// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/join/fit/dense_factor.hpp>
#include <mapjoin/join/fit/leave_one_out.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/cross_covariances.hpp>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// The share of redundancy below which a direction is not tested, as M is the difference of nearly equal numbers; less where M
/// is computed from solutions for the factor itself, which do not cancel.
constexpr double kLeastRedundancy = 1e-6;
constexpr double kLeastSolvedRedundancy = 1e-8;
/// The share of the largest below which eigenvalues and pivots are not tested, as M, a difference, has no digits there.
constexpr double kLeastPivot = 1e-9;
/// The number of tests from which on a scale is estimated, and the quantiles that are compared.
constexpr std::size_t kLeastTests = 20;
constexpr double kQuantiles[] = {0.5, 0.9, 0.95};
/// The number of columns that are solved at once.
constexpr Eigen::Index kColumnsAtOnce = 64;

/// The variables of a factor that are not constant, and their columns in its J.
struct FactorVariables {
  std::vector<Variable> variables;
  std::vector<Eigen::Index> columns;
};
template <int Dim>
FactorVariables variables_of(std::size_t factor, const NormalEquations& equations) {
  FactorVariables found;
  for_each_variable<Dim>(equations, factor, [&](Variable v, Eigen::Index column) {
    found.variables.push_back(v);
    for (int i = 0; i < equations.dof(v); ++i) found.columns.push_back(column + i);
  });
  return found;
}

/// The covariance J P Jᵀ of what the estimate predicts for a factor.
struct PredictedCovariance {
  Eigen::MatrixXd covariance;
  /// Bounds on that of its diagonal, often a hundred times as large: the covariances of poses far from the gauge nearly cancel.
  Eigen::VectorXd rounding;
};
template <int Dim>
PredictedCovariance predicted_covariance(const Eigen::MatrixXd& J, std::size_t factor, const NormalEquations& equations,
                                         const Marginals& marginals) {
  const auto [variables, columns] = variables_of<Dim>(factor, equations);
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(J.cols(), J.cols());
  P(columns, columns) = marginals.joint(variables);
  constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();
  return {J * P * J.transpose(), kRounding * (J.cwiseAbs() * P.diagonal().cwiseSqrt()).cwiseAbs2()};
}

/// The information of a part of a factor; an observation is one part.
template <int Dim, int Dof>
const Matrix<Dof>& information(const LinearObservation<Dim, Dof>& linear, const MeasuredPart&) {
  return linear.W;
}
template <int Dim>
auto information(const LinearMap<Dim>& linear, const MeasuredPart& part) {
  return linear.map->information.block(part.row, part.row, part.rows, part.rows);
}

/// True if M exceeds least · W in all directions, as it does for most parts.
bool has_all_directions(const Eigen::MatrixXd& M, const Eigen::MatrixXd& W, double least) {
  const Eigen::LLT<Eigen::MatrixXd> llt(M - least * W);
  if (llt.info() != Eigen::Success) return false;
  return (llt.matrixLLT().diagonal().array().square() > kLeastPivot * W.diagonal().array()).all();
}

/// Eigenvectors with eigenvalues above `least`, divided by the roots of these: the columns B with Bᵀ A B = I.
Eigen::MatrixXd scaled_eigenvectors(const Eigen::MatrixXd& A, double least) {
  if (A.rows() == 0) return A;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(A);
  const Eigen::Index count = (eigen.eigenvalues().array() > least).count();
  return eigen.eigenvectors().rightCols(count) * eigen.eigenvalues().tail(count).cwiseSqrt().cwiseInverse().asDiagonal();
}

/// The columns B with Bᵀ W B = I over the directions that W measures.
Eigen::MatrixXd whitening(const Eigen::MatrixXd& W) {
  const auto scaled = unit_scaled<Eigen::Dynamic>(W);
  return scaled.scale.asDiagonal() * scaled_eigenvectors(scaled.W, kLeastPivot);
}

/// The columns B with Bᵀ M B = I over the directions in which M is at least the share `least` of W, given as whitening(W):
/// M⁺ = B Bᵀ there.
Eigen::MatrixXd testable_directions(const Eigen::MatrixXd& M, const Eigen::MatrixXd& of_W, double least) {
  return of_W * scaled_eigenvectors(of_W.transpose() * M * of_W, least);
}

}  // namespace

template <int Dim>
LeaveOneOut<Dim>::LeaveOneOut(const JoiningSystem<Dim>& system, const NormalEquations& equations, const Marginals& marginals)
    : system_(system),
      equations_(equations),
      marginals_(marginals),
      step_(equations.solve(equations.gradient())),
      moved_(Eigen::VectorXd::Zero(equations.size())),
      offsets_{0},
      least_redundancies_(factor_count()) {
  for (std::size_t k = 0; k < factor_count(); ++k) {
    const auto rows = static_cast<std::size_t>(system.rows(k));
    offsets_.push_back(offsets_.back() + rows * (rows + 1));
  }
  values_.resize(offsets_.back());
  chi2_ = parallel_sum(factor_count(), kObservationsPerPiece, [&](std::size_t k) {
    const DenseFactor factor = dense_factor(system, k);
    const Eigen::VectorXd r = factor.r - times<Dim>(factor.J, step_, k, equations);
    g(k) = factor.W * r;
    const auto [covariance, rounding] = predicted_covariance<Dim>(factor.J, k, equations, marginals);
    M(k) = factor.W - factor.W * covariance * factor.W;
    least_redundancies_[k] = std::max(kLeastRedundancy, factor.W.diagonal().dot(rounding));
    return r.dot(g(k));
  });
}

template <int Dim>
bool LeaveOneOut<Dim>::is_rounded(std::size_t factor) const {
  return least_redundancies_[factor] > kLeastRedundancy;
}

template <int Dim>
void LeaveOneOut<Dim>::solve_for_weak(std::span<const std::size_t> factors, const std::stop_token& stop) {
  std::vector<std::size_t> weak;
  for (const std::size_t k : factors) {
    const Eigen::MatrixXd W = dense_factor(system_, k).W;
    if (has_all_directions(M(k), W, least_redundancies_[k])) continue;
    const Eigen::MatrixXd of_W = whitening(W);
    if (testable_directions(M(k), of_W, least_redundancies_[k]).cols() < of_W.cols()) weak.push_back(k);
  }
  if (weak.empty()) return;
  const std::vector<bool> are_lone = lone_ties(equations_.pattern());
  for (const std::size_t k : weak) {
    if (stop.stop_requested()) return;
    if (!are_lone[k]) solve_for(k);
  }
}

/// Uses M = W (I - J P Jᵀ W), where P Jᵀ W is solved for: poses far from the gauge then move together by next to nothing, while
/// their covariances are large and nearly cancel.
template <int Dim>
void LeaveOneOut<Dim>::solve_for(std::size_t factor) {
  const auto [r, W, J] = dense_factor(system_, factor);
  const auto [variables, columns] = variables_of<Dim>(factor, equations_);
  const Eigen::MatrixXd J_variables = J(Eigen::all, columns);
  const Eigen::MatrixXd solved = CrossCovariances(equations_).solved(variables, J_variables.transpose() * W);
  const Eigen::MatrixXd product = W * (Eigen::MatrixXd::Identity(J.rows(), J.rows()) - J_variables * solved);
  M(factor) = 0.5 * (product + product.transpose());
  least_redundancies_[factor] = kLeastSolvedRedundancy;
}

template <int Dim>
PartTest LeaveOneOut<Dim>::test(const MeasuredPart& part) const {
  const Eigen::MatrixXd W =
      system_.with_linear_factor(part.factor, [&](const auto& linear) -> Eigen::MatrixXd { return information(linear, part); });
  const Eigen::MatrixXd M_A = M(part.factor).block(part.row, part.row, part.rows, part.rows);
  const auto g_A = g(part.factor).segment(part.row, part.rows);
  const double least = least_redundancies_[part.factor];
  if (has_all_directions(M_A, W, least)) {
    return {g_A.dot(M_A.llt().solve(g_A)), static_cast<int>(part.rows), W.llt().solve(M_A).trace()};
  }
  const Eigen::MatrixXd B = testable_directions(M_A, whitening(W), least);
  const double redundancy = (B.transpose() * W * B).diagonal().cwiseInverse().sum();  // it is diagonal
  return {(B.transpose() * g_A).squaredNorm(), static_cast<int>(B.cols()), redundancy};
}

/// Uses (W⁻¹ + C)⁻¹ = (I + W C)⁻¹ W, as W may be singular.
template <int Dim>
PartTest LeaveOneOut<Dim>::prediction(std::size_t factor) const {
  const auto [r, W, J] = dense_factor(system_, factor);
  auto [C, rounding] = predicted_covariance<Dim>(J, factor, equations_, marginals_);
  C.diagonal() += rounding;
  Eigen::MatrixXd I_WC = W * C;
  I_WC.diagonal().array() += 1.0;
  const Eigen::VectorXd at_optimum = r - times<Dim>(J, step_, factor, equations_);
  const Eigen::VectorXd Wr = W * at_optimum;
  return {at_optimum.dot(I_WC.partialPivLu().solve(Wr)), static_cast<int>(r.size()), 0.0};
}

/// A second part that is left out is tied to the first: its shift takes the share of those before it along, so that none of
/// them comes back in.
template <int Dim>
double LeaveOneOut<Dim>::leave_out(const MeasuredPart& part) {
  const DenseFactor factor = dense_factor(system_, part.factor);
  const Eigen::MatrixXd B = testable_directions(M(part.factor).block(part.row, part.row, part.rows, part.rows),
                                                whitening(factor.W.block(part.row, part.row, part.rows, part.rows)),
                                                least_redundancies_[part.factor]);
  const Eigen::VectorXd size = B.transpose() * g(part.factor).segment(part.row, part.rows);
  const Eigen::Index before = shifts_.rows();
  Eigen::MatrixXd shifts = Eigen::MatrixXd::Zero(before + part.rows, B.cols());
  shifts.bottomRows(part.rows) = B;
  left_out_.push_back(part);
  for (Eigen::Index first = 0; first < B.cols(); first += kColumnsAtOnce) {
    const Eigen::Index count = std::min(kColumnsAtOnce, B.cols() - first);
    auto columns = shifts.middleCols(first, count);
    if (before > 0) columns.topRows(before) = -shifts_ * (shifts_.transpose() * M_times(columns).topRows(before));
    const Eigen::MatrixXd moved = moved_by(columns);
    subtract(columns, moved, size.segment(first, count));
    moved_ += moved * size.segment(first, count);
  }
  shifts_.conservativeResizeLike(Eigen::MatrixXd::Zero(shifts.rows(), shifts_.cols() + B.cols()));
  shifts_.rightCols(B.cols()) = shifts;
  return system_.step_size(moved_).radians;
}

template <int Dim>
Eigen::MatrixXd LeaveOneOut<Dim>::moved_by(const Eigen::MatrixXd& shifts) const {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(equations_.size(), shifts.cols());
  Eigen::Index row = 0;
  for (const MeasuredPart& part : left_out_) {
    const DenseFactor factor = dense_factor(system_, part.factor);
    const Eigen::MatrixXd Jt_W =
        factor.J.transpose() * (factor.W.middleCols(part.row, part.rows) * shifts.middleRows(row, part.rows));
    for_each_variable<Dim>(equations_, part.factor, [&](Variable v, Eigen::Index column) {
      columns.middleRows(equations_.offset(v), equations_.dof(v)) += Jt_W.middleRows(column, equations_.dof(v));
    });
    row += part.rows;
  }
  return equations_.solve_columns(columns);
}

template <int Dim>
Eigen::MatrixXd LeaveOneOut<Dim>::M_times(const Eigen::MatrixXd& shifts, const Eigen::MatrixXd& moved,
                                          std::size_t factor) const {
  const DenseFactor dense = dense_factor(system_, factor);
  Eigen::MatrixXd product = -(dense.W * times<Dim>(dense.J, moved, factor, equations_));
  Eigen::Index row = 0;
  for (const MeasuredPart& part : left_out_) {
    if (part.factor == factor) product += dense.W.middleCols(part.row, part.rows) * shifts.middleRows(row, part.rows);
    row += part.rows;
  }
  return product;
}

template <int Dim>
Eigen::MatrixXd LeaveOneOut<Dim>::M_times(const Eigen::MatrixXd& shifts) const {
  const Eigen::MatrixXd moved = moved_by(shifts);
  Eigen::MatrixXd product(shifts.rows(), shifts.cols());
  Eigen::Index row = 0;
  for (const MeasuredPart& part : left_out_) {
    product.middleRows(row, part.rows) = M_times(shifts, moved, part.factor).middleRows(part.row, part.rows);
    row += part.rows;
  }
  return product;
}

template <int Dim>
void LeaveOneOut<Dim>::subtract(const Eigen::MatrixXd& shifts, const Eigen::MatrixXd& moved, const Eigen::VectorXd& size) {
  parallel_for(factor_count(), [&](std::size_t k) {
    const Eigen::MatrixXd M_B = M_times(shifts, moved, k);
    g(k) -= M_B * size;
    M(k) -= M_B * M_B.transpose();
  });
}

double scale_of(std::span<const PartTest> tests, int rows) {
  std::vector<double> chi2;
  for (const PartTest& test : tests) {
    if (test.rows == rows) chi2.push_back(test.chi2);
  }
  if (chi2.size() < kLeastTests) return 1.0;
  const auto count = static_cast<double>(chi2.size());
  double scale = 0.0;
  for (const double p : kQuantiles) scale = std::max(scale, sample_quantile(chi2, p) / chi_squared_quantile(p, rows));
  return std::clamp((1.0 + std::sqrt(6.0 / count)) * scale, kLeastScale, 1.0);
}

template class LeaveOneOut<2>;
template class LeaveOneOut<3>;

}  // namespace mapjoin
