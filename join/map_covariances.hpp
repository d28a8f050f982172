// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How certain a global map is: covariances of poses and features, alone, together, and relative to each other.
//
// A covariance is that of the step of a variable: of a pose, its translation in the frame of the map (m), then its rotation as
// a rotation vector on the right (rad); of a feature, its position (m). It is relative to the gauge: poses held still have
// none.

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <mapjoin/join/join.hpp>
#include <mapjoin/join/own_given_shared.hpp>
#include <mapjoin/join/relations.hpp>
#include <mapjoin/localmap/segment.hpp>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin {

/// About which estimate the observations are linearised.
enum class Estimate : std::uint8_t {
  kJoined,    ///< By the local maps' Gaussians; what they eliminated, given the joined state, by their own observations.
  kPolished,  ///< By every observation of the log: the inverse of the information of full SLAM.
};

constexpr auto enum_names(Estimate) {
  return std::to_array<EnumName<Estimate>>({{Estimate::kJoined, "joined"}, {Estimate::kPolished, "polished"}});
}

/// A pose or a feature of a network, by its index.
struct PoseOrFeature {
  bool is_pose = true;
  Index index = 0;

  static PoseOrFeature pose(Index index) { return {true, index}; }
  static PoseOrFeature feature(Index index) { return {false, index}; }
};

template <int Dim>
struct MarginalCovariances {
  std::vector<PoseMatrix<Dim>> poses;  ///< Zero where the pose is held.
  std::vector<PointMatrix<Dim>> features;
  Relations<Dim> relations;  ///< The same map in relative form.
};

/// Errors of all functions: kTooLarge where more memory would be asked for than there may be, before it is asked for; bad input
/// where an information matrix is singular.
template <int Dim>
class MapCovariances {
 public:
  /// Linearises at `state`, the estimate of the whole network, and factorises with the join's own pattern and ordering.
  /// `segments` are those of the network's maps, in the order of the maps, or none where there is no log: then nothing has an
  /// interior. `most_memory` is in bytes, 0 for that of the machine. What the network points into must outlive the result.
  static Expected<MapCovariances> make(Network<Dim> network, Join<Dim> join, std::vector<Segment<Dim>> segments,
                                       State<Dim> state, Estimate estimate, std::int64_t most_memory = 0);

  Estimate estimate() const { return estimate_; }
  const Network<Dim>& network() const { return network_; }
  const std::vector<Segment<Dim>>& segments() const { return segments_; }
  const State<Dim>& state() const { return state_; }
  /// The gauge: poses held still; empty where priors hold the map.
  const std::vector<Index>& held() const { return join_.held; }

  /// Of every pose and feature, eliminated ones, too, in the map and relative to what they hang from. At about twice the cost
  /// of the factorisation, and per map that of its elimination. `progress` is given what is done and what there is to do, from
  /// one thread at a time; kInterrupted on `stop`.
  Expected<MarginalCovariances<Dim>> marginals(const std::function<void(std::size_t, std::size_t)>& progress = nullptr,
                                               const std::stop_token& stop = {}) const;
  /// Of all of `variables` together, in their order (kPoseDof<Dim> rows a pose, Dim rows a feature).
  Expected<Eigen::MatrixXd> joint(std::span<const PoseOrFeature> variables) const;
  /// Of a pose in the frame of another: a step of between(base, target).
  Expected<PoseMatrix<Dim>> relative_pose(Index base, Index target) const;
  /// Of a feature in the frame of a pose (m).
  Expected<PointMatrix<Dim>> relative_feature(Index base, Index feature) const;

 private:
  /// Where a pose or feature is at home: a variable of the joined state, or an own variable of a map, or held.
  struct Home {
    Index variable = kConstant;
    Index map = -1;
    Eigen::Index own = -1;
  };
  MapCovariances(Network<Dim> network, Join<Dim> join, std::vector<Segment<Dim>> segments, State<Dim> state, Estimate estimate,
                 std::int64_t most_memory);
  /// False where the information is singular.
  bool factorise();
  void find_homes();

  const NormalEquations& equations() const { return join_.system->equations(); }
  const Home& home(const PoseOrFeature& variable) const {
    return (variable.is_pose ? pose_homes_ : feature_homes_)[static_cast<std::size_t>(variable.index)];
  }
  std::size_t own_poses(std::size_t map) const { return segments_.empty() ? 0 : segments_[map].interior.size(); }
  std::size_t own_features(std::size_t map) const { return network_.maps[map].private_features.size(); }
  Expected<OwnGivenShared<Dim>> own_of(std::size_t map) const;
  /// For each entry that a map shares, the one of the normal equations, or -1 where it is held.
  std::vector<Eigen::Index> shared_entries(std::size_t map) const;
  /// The joint covariance of joined variables that one observation ties together; zero where one is held.
  Eigen::MatrixXd joined_covariance(std::span<const Index> slots, const Marginals& marginals) const;
  void add_joined(const Marginals& marginals, MarginalCovariances<Dim>& out) const;
  Expected<void> add_own(std::size_t map, const Marginals& marginals, MarginalCovariances<Dim>& out) const;
  /// The pose that an own variable of a map hangs from, among the map's own, or its column among what is shared.
  struct OwnParent {
    Eigen::Index own = -1;
    Eigen::Index column = -1;
  };
  OwnParent parent_of(const OwnGivenShared<Dim>& own, std::size_t map, Eigen::Index k) const;
  /// Own variables of a map, each with its first row in a joint covariance.
  using OwnRows = std::vector<std::pair<Eigen::Index, Eigen::Index>>;
  using Triplets = std::vector<Eigen::Triplet<double>>;
  /// Their part in it: how they follow the joined state, and their own covariance.
  Expected<void> carry_own(std::size_t map, OwnRows asked, Triplets& J_transposed, Eigen::MatrixXd& noise) const;
  std::int64_t marginal_bytes() const;

  Network<Dim> network_;
  Join<Dim> join_;
  std::vector<Segment<Dim>> segments_;
  State<Dim> state_;
  Estimate estimate_;
  std::int64_t most_memory_;
  std::vector<Home> pose_homes_;
  std::vector<Home> feature_homes_;
};

}  // namespace mapjoin
