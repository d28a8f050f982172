// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/relative_join.hpp>
#include <utility>

namespace mapjoin {

template <int Dim>
double RelativeJoin<Dim>::linearise() {
  is_damped_ = is_curved_ = is_weighed_ = false;
  const double chi2 = join_.linearise();
  relative_.linearise(join_);
  return chi2;
}

template <int Dim>
void RelativeJoin<Dim>::add_curvature() {
  join_.add_curvature();
  is_curved_ = true;
}

template <int Dim>
const RelativeState<Dim>& RelativeJoin<Dim>::metric() {
  if (!is_weighed_) relative_.weigh(join_);
  is_weighed_ = true;
  return relative_;
}

template <int Dim>
void RelativeJoin<Dim>::undamp() {
  if (!std::exchange(is_damped_, false)) return;
  join_.linearise();
  if (is_curved_) join_.add_curvature();
}

template <int Dim>
double RelativeJoin<Dim>::curvature(const Eigen::VectorXd& v) {
  undamp();
  return join_.curvature(v);
}

template <int Dim>
std::optional<Variable> RelativeJoin<Dim>::factorise(double damping) {
  undamp();
  is_factor_curved_ = is_curved_;
  is_damped_ = damping > 0.0;
  if (is_damped_) metric().damp(join_, damping);
  return join_.factorise(0.0);
}

template <int Dim>
MinimiseResult minimise_join(JoiningSystem<Dim>& join, JoinedState state, const MinimiseOptions& options,
                             const std::stop_token& stop) {
  if (state == JoinedState::kAbsolute) return minimise(join, options, stop);
  RelativeJoin<Dim> relative(join);
  return minimise(relative, options, stop);
}

template class RelativeJoin<2>;
template class RelativeJoin<3>;
template MinimiseResult minimise_join(JoiningSystem<2>&, JoinedState, const MinimiseOptions&, const std::stop_token&);
template MinimiseResult minimise_join(JoiningSystem<3>&, JoinedState, const MinimiseOptions&, const std::stop_token&);

}  // namespace mapjoin
