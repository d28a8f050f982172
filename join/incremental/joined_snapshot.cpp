// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <mapjoin/join/incremental/joined_snapshot.hpp>

namespace mapjoin {

template <int Dim>
template <typename Id>
std::optional<JoinedIndex> JoinedSnapshot<Dim>::find(const Id& id) const {
  const auto v = names_->find(id);
  return v && v->position() < estimate_.variables.size() ? v : std::nullopt;
}

template <int Dim>
std::optional<Pose<Dim>> JoinedSnapshot<Dim>::pose(const PoseId& id) const {
  const auto v = find(id);
  return v ? std::optional(estimate_.variables[*v].value) : std::nullopt;
}

template <int Dim>
std::optional<Point<Dim>> JoinedSnapshot<Dim>::feature(const FeatureId& id) const {
  const auto v = find(id);
  return v ? std::optional(estimate_.variables[*v].value.translation) : std::nullopt;
}

template <int Dim>
template <typename Matrix, typename Id>
std::optional<Matrix> JoinedSnapshot<Dim>::covariance_of(const Id& id) const {
  const auto v = find(id);
  const auto covariance = v ? estimate_.covariance({&*v, 1}) : std::nullopt;
  return covariance ? std::optional<Matrix>(*covariance) : std::nullopt;
}

template <int Dim>
std::optional<PoseMatrix<Dim>> JoinedSnapshot<Dim>::covariance(const PoseId& id) const {
  return covariance_of<PoseMatrix<Dim>>(id);
}

template <int Dim>
std::optional<PointMatrix<Dim>> JoinedSnapshot<Dim>::covariance(const FeatureId& id) const {
  return covariance_of<PointMatrix<Dim>>(id);
}

template <int Dim>
std::optional<Matrix<2 * kPoseDof<Dim>>> JoinedSnapshot<Dim>::covariance(const PoseId& first, const PoseId& second) const {
  const auto a = find(first);
  const auto b = find(second);
  if (!a || !b) return std::nullopt;
  const auto covariance = estimate_.covariance(std::array{*a, *b});
  return covariance ? std::optional<Matrix<2 * kPoseDof<Dim>>>(*covariance) : std::nullopt;
}

template class JoinedSnapshot<2>;
template class JoinedSnapshot<3>;

}  // namespace mapjoin
