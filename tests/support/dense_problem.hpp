// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Least-squares problems over a few numbers, for minimise().

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>
#include <mapjoin/solve/minimise.hpp>
#include <optional>
#include <tests/support/numerical_jacobian.hpp>
#include <vector>

namespace mapjoin::testing {

/// A LeastSquaresProblem over a dense vector x with the residual r(x) = -h(x): h was measured as zero. Records chi2 at every
/// linearisation.
class DenseProblem {
 public:
  using Function = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;
  DenseProblem(Function h, Eigen::VectorXd start) : h_(std::move(h)), x_(std::move(start)) {}

  double linearise() {
    const Eigen::VectorXd r = -h_(x_);
    const Eigen::MatrixXd J = numerical_jacobian([&](const Eigen::VectorXd& step) { return h_(x_ + step); }, x_.size());
    H_ = J.transpose() * J;
    g_ = J.transpose() * r;
    visited.push_back(r.squaredNorm());
    return r.squaredNorm();
  }
  void add_curvature() {
    const auto gradient = [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
      const auto h = [&](const Eigen::VectorXd& more) { return h_(x_ + step + more); };
      return numerical_jacobian(h, x_.size(), 1e-5).transpose() * h_(x_ + step);
    };
    H_ = numerical_jacobian(gradient, x_.size(), 1e-5);
  }
  Eigen::VectorXd gradient() const { return g_; }
  DiagonalMetric metric() const { return DiagonalMetric(H_.diagonal()); }
  double curvature(const Eigen::VectorXd& v) const { return v.dot(H_ * v); }
  std::optional<Variable> factorise(double damping) {
    ++factorisations;
    Eigen::MatrixXd damped = H_;
    damped.diagonal() *= 1.0 + damping;
    llt_.compute(damped);
    const Eigen::VectorXd pivots = llt_.matrixLLT().diagonal().cwiseAbs2();
    for (Eigen::Index i = 0; i < pivots.size(); ++i) {
      if (!(pivots[i] > 1e-14 * damped(i, i))) return Variable(i);
    }
    if (llt_.info() != Eigen::Success) return Variable(1);  // the pivot of the second of two variables
    return std::nullopt;
  }
  Eigen::VectorXd solve() const { return llt_.solve(g_); }
  StepSize step_size(const Eigen::VectorXd& v) const { return {v.norm(), 0.0}; }
  double try_step(const Eigen::VectorXd& v) {
    candidate_ = x_ + v;
    return h_(candidate_).squaredNorm();
  }
  void accept() { x_ = candidate_; }

  const Eigen::VectorXd& estimate() const { return x_; }
  std::vector<double> visited;
  int factorisations = 0;

 private:
  Function h_;
  Eigen::VectorXd x_;
  Eigen::MatrixXd H_;
  Eigen::VectorXd candidate_;
  Eigen::VectorXd g_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

inline Eigen::VectorXd rosenbrock(const Eigen::VectorXd& x) {
  return Eigen::Vector2d(10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]);
}

/// A function whose minimum, at 0, Gauss-Newton steps away from if it starts beyond 1.4.
inline Eigen::VectorXd arctangent(const Eigen::VectorXd& x) {
  return Eigen::VectorXd::Constant(1, std::atan(x[0]));
}

/// Options of a minimisation that goes on to the last digits of chi2.
inline MinimiseOptions to_the_end(Method method) {
  MinimiseOptions options;
  options.method = method;
  options.relative_chi2 = 1e-14;
  return options;
}

}  // namespace mapjoin::testing
