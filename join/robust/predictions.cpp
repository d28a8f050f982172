// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <mapjoin/join/robust/predictions.hpp>
#include <mapjoin/parallel/parallel.hpp>

namespace mapjoin {
namespace {

/// Landing places whose columns are solved for together: as many as fill a vector unit, and take little memory.
constexpr std::size_t kPlacesAtOnce = 8;

template <int Dim>
class Predictions {
 public:
  Predictions(const JoiningSystem<Dim>& system, const Marginals& marginals, std::span<const PoseFactor<Dim>> closures,
              std::size_t most_places)
      : system_(system),
        closures_(closures),
        places_(std::min(most_places, poses().size())),
        covariances_(poses().size(), PoseMatrix<Dim>::Zero()),
        independent_(closures.size()),
        is_far_(closures.size()),
        mismatches_(closures.size()) {
    parallel_for(closures.empty() ? 0 : poses().size(), [&](std::size_t p) {
      const Variable v = system.variable(PoseIndex(p));
      if (v != kConstant) covariances_[PoseIndex(p)] = marginals[v];
    });
  }

  std::vector<UncertainPose<Dim>> all(double far, const std::stop_token& stop) {
    parallel_for(closures_.size(), [&](std::size_t k) { begin(k, far); });
    const std::vector<std::size_t> needed = needed_places();
    for (std::size_t k = 0; k < needed.size() && !stop.stop_requested(); k += kPlacesAtOnce) {
      land_at(std::span(needed).subspan(k, std::min(kPlacesAtOnce, needed.size() - k)));
    }
    return std::move(mismatches_);
  }

 private:
  static constexpr int kDof = kPoseDof<Dim>;
  const Table<PoseIndex, Pose<Dim>>& poses() const { return system_.estimate().poses; }
  std::size_t place_beside(PoseIndex pose) const { return pose.position() * places_ / poses().size(); }
  PoseIndex pose_at(std::size_t place) const { return PoseIndex((2 * place + 1) * poses().size() / (2 * places_)); }
  auto linear(std::size_t k) const {
    return linearise<Dim>(closures_[k].measured, poses()[closures_[k].base], poses()[closures_[k].target]);
  }

  /// As if the ends were independent. However they are correlated, they add at most twice as much.
  void begin(std::size_t k, double far) {
    const auto linear = this->linear(k);
    const PoseMatrix<Dim> measured = covariance_of(closures_[k].information);
    independent_[k] = measured + linear.J_base * covariances_[closures_[k].base] * linear.J_base.transpose() +
                      linear.J_target * covariances_[closures_[k].target] * linear.J_target.transpose();
    const PoseMatrix<Dim> most = 2.0 * independent_[k] - measured;
    is_far_[k] = linear.residual.dot(most.llt().solve(linear.residual)) > far;
    mismatches_[k] = {retract(Pose<Dim>{}, linear.residual), is_far_[k] ? most : independent_[k]};
  }

  /// Those beside the ends of closures that are not far, ascending.
  std::vector<std::size_t> needed_places() const {
    std::vector<std::size_t> needed;
    for (std::size_t k = 0; k < closures_.size(); ++k) {
      if (is_far_[k]) continue;
      needed.push_back(place_beside(closures_[k].base));
      needed.push_back(place_beside(closures_[k].target));
    }
    std::ranges::sort(needed);
    needed.erase(std::ranges::unique(needed).begin(), needed.end());
    return needed;
  }

  /// Lowers the covariances of closures with an end beside one of the places.
  void land_at(std::span<const std::size_t> places) {
    const NormalEquations& equations = system_.equations();
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(equations.size(), static_cast<Eigen::Index>(places.size()) * kDof);
    for (std::size_t b = 0; b < places.size(); ++b) {
      const Variable v = system_.variable(pose_at(places[b]));
      if (v != kConstant) unit.block<kDof, kDof>(equations.offset(v), static_cast<Eigen::Index>(b) * kDof).setIdentity();
    }
    const Eigen::MatrixXd columns = equations.solve_columns(unit);
    parallel_for(closures_.size(), [&](std::size_t k) {
      for (const PoseIndex end : {closures_[k].base, closures_[k].target}) {
        const auto place = std::ranges::lower_bound(places, place_beside(end));
        if (is_far_[k] || place == places.end() || *place != place_beside(end)) continue;
        lower(k, pose_at(*place), columns.middleCols<kDof>((place - places.begin()) * kDof));
      }
    });
  }

  /// By the columns of a landing place.
  template <typename Columns>
  void lower(std::size_t k, PoseIndex place, const Columns& columns) {
    const Eigen::LLT<PoseMatrix<Dim>> P_place(covariances_[place]);
    if (P_place.info() != Eigen::Success) return;  // the pose that holds the map
    const auto with_place = [&](PoseIndex pose) -> PoseMatrix<Dim> {
      const Variable v = system_.variable(pose);
      if (v == kConstant) return PoseMatrix<Dim>::Zero();
      return columns.template middleRows<kDof>(system_.equations().offset(v));
    };
    const auto linear = this->linear(k);
    const PoseMatrix<Dim> across = linear.J_base * with_place(closures_[k].base) *
                                   P_place.solve(with_place(closures_[k].target).transpose()) * linear.J_target.transpose();
    const PoseMatrix<Dim> S = independent_[k] + across + across.transpose();
    if (S.trace() < mismatches_[k].covariance.trace()) mismatches_[k].covariance = S;
  }

  const JoiningSystem<Dim>& system_;
  std::span<const PoseFactor<Dim>> closures_;
  std::size_t places_;
  Table<PoseIndex, PoseMatrix<Dim>> covariances_;
  std::vector<PoseMatrix<Dim>> independent_;
  std::vector<std::uint8_t> is_far_;
  std::vector<UncertainPose<Dim>> mismatches_;
};

}  // namespace

template <int Dim>
std::vector<UncertainPose<Dim>> mismatches(const JoiningSystem<Dim>& system, const Marginals& marginals,
                                           std::span<const PoseFactor<Dim>> closures, const PredictionOptions& options,
                                           const std::stop_token& stop) {
  return Predictions<Dim>(system, marginals, closures, options.places).all(options.far, stop);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                  \
  template std::vector<UncertainPose<Dim>> mismatches(const JoiningSystem<Dim>&, const Marginals&,                \
                                                      std::span<const PoseFactor<Dim>>, const PredictionOptions&, \
                                                      const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
