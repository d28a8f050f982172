// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <mapjoin/check/checks.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/information.hpp>
#include <type_traits>
#include <utility>

namespace mapjoin {
namespace {

constexpr double kLeastProbability = 1e-9;

/// Findings on observations of one kind.
struct Repeats {
  Places copies;
  Places contradictions;
  Places others;
};

/// True if two measurements of one thing, with the informations A and B, differ by more than the sum of their covariances
/// allows. Uses (A⁻¹ + B⁻¹)⁻¹ = A (A + B)⁻¹ B, which exists for singular A and B, too; whatever the units of their rows.
template <int Size>
bool contradict(const Vector<Size>& difference, const Matrix<Size>& A, const Matrix<Size>& B) {
  const UnitScaled<Size> scaled = unit_scaled<Size>(A + B);
  const Eigen::MatrixXd sum = scaled.W;  // Dynamic size: a decomposition unrolled for each size takes a minute to compile.
  const Eigen::MatrixXd D_B = scaled.scale.asDiagonal() * B;
  const Matrix<Size> W = A * scaled.scale.asDiagonal() * sum.completeOrthogonalDecomposition().solve(D_B);
  const double chi2 = difference.dot(W * difference);
  const auto rows = information_rank<Size>(Matrix<Size>(0.5 * (W + W.transpose())));
  return chi_squared_upper_tail(chi2, static_cast<double>(rows)) < kLeastProbability;
}

/// The edge seen from its earlier pose: the residual of the inverse is -J r, to first order.
template <int Dim>
PoseFactor<Dim> forward(const PoseFactor<Dim>& edge) {
  if (edge.base < edge.target) return edge;
  PoseMatrix<Dim> J;
  PoseFactor<Dim> turned{edge.target, edge.base, inverse(edge.measured, &J), {}, edge.loss};
  const PoseMatrix<Dim> J_inverse = J.inverse();
  turned.information = J_inverse.transpose() * edge.information * J_inverse;
  return turned;
}
template <int Dim>
const FeatureFactor<Dim>& forward(const FeatureFactor<Dim>& observation) {
  return observation;
}

template <int Dim>
PoseVector<Dim> difference(const PoseFactor<Dim>& a, const PoseFactor<Dim>& b) {
  return local(a.measured, b.measured);
}
template <int Dim>
Point<Dim> difference(const FeatureFactor<Dim>& a, const FeatureFactor<Dim>& b) {
  return b.measured - a.measured;
}

/// The two ends of an observation, whatever its direction.
template <int Dim>
std::pair<PoseIndex, PoseIndex> ends_of(const PoseFactor<Dim>& edge) {
  return std::minmax(edge.base, edge.target);
}
template <int Dim>
std::pair<PoseIndex, FeatureIndex> ends_of(const FeatureFactor<Dim>& observation) {
  return {observation.base, observation.target};
}

/// Compares each observation with the one before it that has the same ends. `name(ends)` names them.
template <typename Observation, typename Name>
Repeats repeats_among(std::span<const Observation> all, const Name& name) {
  std::vector<std::pair<decltype(ends_of(all.front())), std::size_t>> ends;  // ends and the index of their observation
  ends.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) ends.emplace_back(ends_of(all[i]), i);
  std::sort(ends.begin(), ends.end());

  Repeats repeats;
  for (std::size_t k = 1; k < ends.size(); ++k) {
    if (ends[k].first != ends[k - 1].first) continue;
    const auto& a = forward(all[ends[k - 1].second]);
    const auto& b = forward(all[ends[k].second]);
    const std::string named = name(ends[k].first);
    const auto d = difference(a, b).eval();
    if (d.isZero(0.0) && a.information == b.information) {
      repeats.copies.add(named);
    } else if (contradict<std::decay_t<decltype(d)>::RowsAtCompileTime>(d, a.information, b.information)) {
      repeats.contradictions.add(named);
    } else {
      repeats.others.add(named);
    }
  }
  return repeats;
}

void tell(const Repeats& repeats, const std::string& what, std::string_view of_what, Findings& findings) {
  const auto add = [&](FindingLevel level, const char* check, const Places& where, std::string_view how) {
    add_if_any(findings,
               {level, check, fmt::format("{} repeating others {}{}", plural(where.count, what), of_what, how), where});
  };
  add(FindingLevel::kWarning, "copies", repeats.copies, " to the last digit: what was measured once counts twice");
  add(FindingLevel::kWarning, "contradiction", repeats.contradictions,
      ", and contradicting them by more than the covariances allow");
  add(FindingLevel::kNote, "repeated", repeats.others, "; all of them count");
}

}  // namespace

template <int Dim>
Findings check_repeats(const Log<Dim>& log) {
  if (!check_invariants(log)) return {};
  const Repeats of_poses = repeats_among(log.edges(), [&](const auto& ends) {
    return fmt::format("{} to {}", to_string(log.poses[ends.first]), to_string(log.poses[ends.second]));
  });
  const Repeats of_features = repeats_among(log.observations(), [&](const auto& ends) {
    return fmt::format("{} from {}", to_string(log.features[ends.second]), to_string(log.poses[ends.first]));
  });
  Findings findings;
  tell(of_poses, "edge", "between the same two poses", findings);
  tell(of_features, "observation", "of the same feature from the same pose", findings);
  return findings;
}

template Findings check_repeats(const Log<2>&);
template Findings check_repeats(const Log<3>&);

}  // namespace mapjoin
