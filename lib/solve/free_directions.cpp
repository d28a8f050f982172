// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <mapjoin/solve/free_directions.hpp>
#include <numeric>

namespace mapjoin {
namespace {

/// The largest entry of a null vector, relative to its largest, that counts as rounding; metres are in units of the extent.
constexpr double kNothing = 1e-6;
/// The most parts of the map, and variables of each, that are named.
constexpr std::size_t kMostNamedParts = 3;
constexpr std::size_t kMostNames = 4;

/// A rigid motion: the velocity of its centre, then the angular velocity, one number in the plane.
template <int Dim>
constexpr int kMotionDof = kPoseDof<Dim>;
template <int Dim>
using Motion = Vector<kMotionDof<Dim>>;

/// The Jacobian of the velocity of a point, given relative to the centre, with respect to a motion.
template <int Dim>
Matrix<Dim, kMotionDof<Dim>> point_of_motion(const Point<Dim>& p) {
  Matrix<Dim, kMotionDof<Dim>> J;
  J.template leftCols<Dim>().setIdentity();
  if constexpr (Dim == 2) J.col(2) << -p.y(), p.x();
  if constexpr (Dim == 3) J.template rightCols<3>() = -skew(p);
  return J;
}

/// The Jacobian of a variable's step with respect to a motion about `centre`.
template <int Dim>
Eigen::MatrixXd step_of_motion(const PlacedVariable<Dim>& variable, const Point<Dim>& centre) {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(variable.is_pose ? kPoseDof<Dim> : Dim, kMotionDof<Dim>);
  J.topRows(Dim) = point_of_motion<Dim>(variable.value.translation - centre);
  if (!variable.is_pose) return J;
  if constexpr (Dim == 2) {
    J(2, 2) = 1.0;
  } else {
    J.template bottomRightCorner<3, 3>() = variable.value.rotation.matrix().transpose();
  }
  return J;
}

template <int Dim>
Eigen::Index dof_of(const PlacedVariable<Dim>& variable) {
  return variable.is_pose ? kPoseDof<Dim> : Dim;
}

/// Variables that move, and the directions in which they do.
template <int Dim>
struct FreePart {
  std::vector<const PlacedVariable<Dim>*> variables;
  std::vector<Eigen::Index> directions;
};

/// The parts that move independently of each other: directions without variables in common are in different parts.
template <int Dim>
std::vector<FreePart<Dim>> parts_of(const std::vector<PlacedVariable<Dim>>& variables, const Eigen::MatrixXd& N) {
  std::vector<Eigen::Index> part_of(static_cast<std::size_t>(N.cols()));
  std::iota(part_of.begin(), part_of.end(), Eigen::Index{0});
  const auto first_mover = [&](const PlacedVariable<Dim>& variable) {
    Eigen::Index first = -1;
    for (Eigen::Index c = 0; variable.offset >= 0 && c < N.cols(); ++c) {
      if (N.col(c).segment(variable.offset, dof_of(variable)).cwiseAbs().maxCoeff() <= kNothing) continue;
      const Eigen::Index mine = part_of[static_cast<std::size_t>(c)];
      if (first < 0) first = mine;
      std::replace(part_of.begin(), part_of.end(), std::max(first, mine), std::min(first, mine));
      first = std::min(first, mine);
    }
    return first;
  };
  for (const auto& variable : variables) first_mover(variable);
  std::vector<FreePart<Dim>> parts(part_of.size());
  for (const auto& variable : variables) {
    if (const Eigen::Index part = first_mover(variable); part >= 0)
      parts[static_cast<std::size_t>(part)].variables.push_back(&variable);
  }
  for (std::size_t c = 0; c < part_of.size(); ++c) {
    parts[static_cast<std::size_t>(part_of[c])].directions.push_back(static_cast<Eigen::Index>(c));
  }
  std::erase_if(parts, [](const auto& part) { return part.variables.empty(); });
  return parts;
}

/// The directions of a part as rigid motions of all its variables together; empty if they are not rigid.
template <int Dim>
std::vector<Motion<Dim>> rigid_motions(const FreePart<Dim>& part, const Point<Dim>& centre, const Eigen::MatrixXd& N) {
  Eigen::Index rows = 0;
  for (const auto* variable : part.variables) rows += dof_of(*variable);
  Eigen::MatrixXd J(rows, kMotionDof<Dim>);
  Eigen::MatrixXd steps(rows, static_cast<Eigen::Index>(part.directions.size()));
  Eigen::Index row = 0;
  for (const auto* variable : part.variables) {
    const Eigen::Index dof = dof_of(*variable);
    J.middleRows(row, dof) = step_of_motion(*variable, centre);
    steps.middleRows(row, dof) = N.middleRows(variable->offset, dof)(Eigen::all, part.directions);
    row += dof;
  }
  const Eigen::MatrixXd motions = J.completeOrthogonalDecomposition().solve(steps);
  if ((J * motions - steps).cwiseAbs().maxCoeff() > kNothing) return {};
  std::vector<Motion<Dim>> result;
  for (const auto& motion : motions.colwise()) result.emplace_back(motion);
  return result;
}

template <int Dim>
bool stands_still(const Point<Dim>& p, const std::vector<Motion<Dim>>& motions) {
  const auto J = point_of_motion<Dim>(p);
  return std::all_of(motions.begin(), motions.end(), [&](const auto& motion) {
    return (J * motion).norm() <= 10.0 * kNothing * (1.0 + p.norm()) * motion.norm();
  });
}

/// A list of names in words: "pose 5", "pose 5 and pose 6", "pose 5, pose 6 and 7 others".
std::string listed(std::vector<std::string> names) {
  if (names.size() > kMostNames) {
    const std::size_t others = names.size() - kMostNames + 1;
    names.resize(kMostNames - 1);
    names.push_back(fmt::format("{} others", others));
  }
  const std::string last = names.back();
  names.pop_back();
  return names.empty() ? last : fmt::format("{} and {}", fmt::join(names, ", "), last);
}

template <int Dim>
std::string motion_in_words(const FreePart<Dim>& part, const std::vector<PlacedVariable<Dim>>& all, const Eigen::MatrixXd& N) {
  const bool is_single = part.variables.size() == 1;
  if (is_single && static_cast<Eigen::Index>(part.directions.size()) == dof_of(*part.variables.front())) return "move";
  Point<Dim> centre = Point<Dim>::Zero();
  for (const auto* variable : part.variables) centre += variable->value.translation;
  centre /= static_cast<double>(part.variables.size());
  const auto motions = rigid_motions(part, centre, N);
  if (motions.empty()) return "move against each other";
  const std::string as_a_whole = is_single ? "" : " as a whole";
  const bool turns = std::any_of(motions.begin(), motions.end(),
                                 [](const auto& m) { return m.template tail<kRotationDof<Dim>>().norm() > kNothing; });
  if (!turns) return "move" + as_a_whole;
  std::vector<std::string> pivots;
  for (const auto& variable : all) {
    if (stands_still<Dim>(variable.value.translation - centre, motions)) pivots.push_back(variable.name);
  }
  if (pivots.empty()) return "move and turn" + as_a_whole;
  if (is_single && pivots.front() == part.variables.front()->name) return "turn";
  return "turn" + as_a_whole + " about " + listed(pivots);
}

}  // namespace

template <int Dim>
double extent_of(const std::vector<PlacedVariable<Dim>>& variables) {
  double extent = 0.0;
  for (const auto& variable : variables) {
    extent = std::max(extent, (variable.value.translation - variables.front().value.translation).norm());
  }
  return extent > 0.0 ? extent : 1.0;
}

template <int Dim>
std::string free_directions(std::vector<PlacedVariable<Dim>> variables, Eigen::MatrixXd N) {
  if (N.cols() == 0) return {};
  const double extent = extent_of(variables);
  for (auto& variable : variables) {
    variable.value.translation /= extent;
    if (variable.offset >= 0) N.middleRows<Dim>(variable.offset) /= extent;
  }
  for (auto column : N.colwise()) column /= column.cwiseAbs().maxCoeff();
  std::vector<std::string> sentences;
  for (const auto& part : parts_of(variables, N)) {
    if (sentences.size() == kMostNamedParts) break;
    std::vector<std::string> names;
    for (const auto* variable : part.variables) names.push_back(variable->name);
    sentences.push_back(fmt::format("{} cannot be determined: the observations leave {} free to {}", listed(names),
                                    names.size() == 1 ? "it" : "them", motion_in_words(part, variables, N)));
  }
  return fmt::format("{}", fmt::join(sentences, "; "));
}

#define MAPJOIN_INSTANTIATE(Dim)                                      \
  template double extent_of(const std::vector<PlacedVariable<Dim>>&); \
  template std::string free_directions(std::vector<PlacedVariable<Dim>>, Eigen::MatrixXd);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
