// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/study/convexity_pairs.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/simulate/random_stream.hpp>

namespace mapjoin {
namespace {

/// S with S Sᵀ = W⁻¹, zero in directions that W does not measure.
template <int Rows>
Eigen::MatrixXd deviation(const Matrix<Rows>& W) {
  const UnitScaled<Rows> scaled = unit_scaled<Rows>(W);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled.W);
  const Eigen::VectorXd values = eigen.eigenvalues();
  const Eigen::VectorXd roots = (values.array() > scaled.rounding).select(values.array().rsqrt(), 0.0);
  return scaled.scale.asDiagonal() * eigen.eigenvectors() * roots.asDiagonal();
}

template <int Rows>
Vector<Rows> normal_vector(Eigen::Index rows, RandomStream& random) {
  Vector<Rows> v(rows);
  for (Eigen::Index i = 0; i < rows; ++i) v[i] = random.normal();
  return v;
}

}  // namespace

template <int Dim>
StateSampler<Dim>::StateSampler(StateSource source, double spread, const PartialMap<Dim>& composed,
                                const JoiningSystem<Dim>& system, const Values<Dim>& reference)
    : source_(source),
      spread_(spread),
      composed_(composed),
      system_(system),
      reference_(reference),
      coordinates_(system, reference) {
  if (source_ == StateSource::kBox) return;
  for (const auto& placed : system.maps()) map_deviations_.push_back(deviation(placed.map->information));
}

template <int Dim>
Values<Dim> StateSampler<Dim>::draw(std::uint64_t seed) const {
  return source_ == StateSource::kBox ? draw_from_box(seed) : draw_drifted(seed);
}

template <int Dim>
Values<Dim> StateSampler<Dim>::draw_from_box(std::uint64_t seed) const {
  PartialMap<Dim> partial = composed_;
  set_to_random(seed, partial);
  for (const PoseIndex p : indices(partial.state.poses)) {
    if (system_.is_anchored(p)) partial.state.poses[p] = reference_.poses[p];
  }
  return unwrapped_near(std::move(partial.state), reference_);
}

template <int Dim>
Values<Dim> StateSampler<Dim>::draw_drifted(std::uint64_t seed) const {
  RandomStream random(seed, 1);
  std::vector<Eigen::VectorXd> map_errors;
  for (const auto& S : map_deviations_) map_errors.push_back(S * normal_vector<Eigen::Dynamic>(S.cols(), random));

  const auto error_of = [&]<int Dof>(const TreeObservation& edge, const Matrix<Dof>& information) -> Vector<Dof> {
    const auto [kind, place] = system_.source_of(edge.factor);
    if (kind != JoiningSystem<Dim>::Source::kMap) return deviation(information) * normal_vector<Dof>(Dof, random);
    return map_errors[place].template segment<Dof>(system_.maps()[place].map->row(edge.target));
  };
  const SpanningTree& tree = coordinates_.tree();
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(coordinates_.size());
  for (std::size_t e = 0; e < tree.poses.size(); ++e) {
    const auto& edge = tree.poses[e].observation;
    if (edge)
      errors.segment<kPoseDof<Dim>>(coordinates_.pose_entry(e)) = error_of(*edge, measured_pose(system_, *edge).information);
  }
  for (const FeatureIndex f : indices(tree.features)) {
    const auto& edge = tree.features[f].observation;
    if (edge) errors.segment<Dim>(coordinates_.feature_entry(f)) = error_of(*edge, measured_point(system_, *edge).information);
  }
  return coordinates_.composed(spread_ * errors);
}

template class StateSampler<2>;
template class StateSampler<3>;

}  // namespace mapjoin
