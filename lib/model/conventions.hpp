// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The conventions of a file's numbers, so that every chi2 can be reported with its meaning.

#include <algorithm>
#include <array>
#include <cstdint>
#include <mapjoin/model/enum_names.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin {

/// The pose-pose residual that a file's information matrices weigh. Internally the residual is always the paper's (10).
enum class PoseError : std::uint8_t {
  kPaper,  ///< X̂ - H(X), translation in the frame of the base.
  kG2o,    ///< Z⁻¹ X_b⁻¹ X_t: translation rotated by R_Zᵀ against the paper's; W is rotated by R_Z on reading.
};

constexpr auto enum_names(PoseError) {
  return std::to_array<EnumName<PoseError>>({{PoseError::kPaper, "paper"}, {PoseError::kG2o, "g2o"}});
}

/// The rotation error that a file's 3D information matrices weigh.
enum class RotationInformation : std::uint8_t {
  kVector,      ///< The rotation vector (GTSAM, SE-Sync); used internally.
  kQuaternion,  ///< The vector part of the unit quaternion, half the rotation vector (g2o).
};

constexpr auto enum_names(RotationInformation) {
  return std::to_array<EnumName<RotationInformation>>(
      {{RotationInformation::kVector, "vector"}, {RotationInformation::kQuaternion, "quaternion"}});
}

/// The information matrices in use.
enum class Covariance : std::uint8_t {
  kOriginal,  ///< As the file gives them.
  kIdentity,  ///< Every information matrix replaced by the identity of what it measures (paper's Table I).
};

constexpr auto enum_names(Covariance) {
  return std::to_array<EnumName<Covariance>>({{Covariance::kOriginal, "original"}, {Covariance::kIdentity, "identity"}});
}

/// Counts of information matrices and covariances that were not taken as the input gives them.
struct MatrixRepairs {
  std::int64_t symmetrised = 0;    ///< Replaced by their symmetric part because of asymmetry above round-off.
  double largest_asymmetry = 0.0;  ///< The largest asymmetry among these, relative to the largest entry of its matrix.
  std::int64_t indefinite = 0;     ///< Replaced by the nearest positive semidefinite matrix (definite for a covariance).
  std::int64_t missing = 0;        ///< Absent, taken as the identity.

  MatrixRepairs& operator+=(const MatrixRepairs& other) {
    symmetrised += other.symmetrised;
    largest_asymmetry = std::max(largest_asymmetry, other.largest_asymmetry);
    indefinite += other.indefinite;
    missing += other.missing;
    return *this;
  }
};

/// Factors on the standard deviations that the input gives to the measurements of a kind.
struct Inflation {
  static constexpr double kLeast = 1e-6;
  static constexpr double kMost = 1e6;

  double closures = 1.0;
  double odometry = 1.0;
  double observations = 1.0;
  double priors = 1.0;
  double maps = 1.0;  ///< Of local maps.

  /// Violated constraints; empty if every factor is from kLeast to kMost.
  std::vector<std::string> validate() const;
  bool operator==(const Inflation&) const = default;
};

/// A kind of measurement, by its word in options, reports and stores.
struct InflatedKind {
  std::string_view name;
  double Inflation::*factor;
};
inline constexpr auto kInflatedKinds = std::to_array<InflatedKind>({{"closure", &Inflation::closures},
                                                                    {"odometry", &Inflation::odometry},
                                                                    {"observation", &Inflation::observations},
                                                                    {"prior", &Inflation::priors},
                                                                    {"map", &Inflation::maps}});

inline std::vector<std::string> Inflation::validate() const {
  const auto is_within = [&](const InflatedKind& kind) { return this->*kind.factor >= kLeast && this->*kind.factor <= kMost; };
  if (std::ranges::all_of(kInflatedKinds, is_within)) return {};
  return {"a factor on standard deviations must be from 1e-6 to 1e6"};
}

struct Conventions {
  PoseError pose_error = PoseError::kPaper;
  RotationInformation rotation_information = RotationInformation::kVector;
  Covariance covariance = Covariance::kOriginal;
  MatrixRepairs repairs = {};
  Inflation inflation = {};
};

/// The conventions of a log without its repairs, for what takes these from the log itself.
inline Conventions without_repairs(Conventions conventions) {
  conventions.repairs = {};
  return conventions;
}

}  // namespace mapjoin
