// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Which features of different local maps are the same, by the joined map of what is known so far.

#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/identities.hpp>
#include <mapjoin/join/association/matching.hpp>
#include <mapjoin/join/association/point_tree.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Two features that may be the same.
struct FeaturePair {
  FeatureIndex one;
  FeatureIndex other;
  bool operator==(const FeaturePair&) const = default;
};

/// Two features that are probably the same.
struct Proposal {
  FeatureIndex one;
  FeatureIndex other;
  Match match;
  std::size_t maps[2] = {0, 0};  ///< That they were matched for, the earlier one first.
};

struct Proposals {
  std::vector<Proposal> probable;  ///< In the order of the later map, then the earlier one.
  std::size_t beyond_reach = 0;    ///< Pairs of maps that were not tried.
};

/// Two maps of which features may be the same.
template <int Dim>
struct MapPair {
  std::size_t maps[2] = {0, 0};  ///< The earlier one first.
  FeaturePair features;          ///< Of either one, that may be mistaken for the fewest others.
  double confusable = 0.0;       ///< These others.
  PointMatrix<Dim> covariance;   ///< Of the difference of the two.
};

/// Pairs of maps are matched with each other, with the joint covariance of their features in the joined map.
template <int Dim>
class MapMatching {
 public:
  /// All must stay.
  MapMatching(const FeatureEstimate<Dim>& estimate, const Identities& identities, const NeighbourDensity<Dim>& density,
              AssociationMethod method, double confidence);

  /// The pairs of maps whose features may lie on each other, and the sightings of one map among themselves, as far as these
  /// were set aside. How far: only where the number of other features that a feature may be mistaken for, for all that is known
  /// of where the maps are, is at most `reach`. With `only_neighbours` maps are matched with the one before them only.
  Proposals propose(double reach, bool only_neighbours, const std::stop_token& stop) const;
  /// All pairs of maps of which features may be the same for all that is known, where each may be mistaken for `reach` others
  /// at most; in the order of the later map, then the earlier one.
  std::vector<MapPair<Dim>> pairs(double reach, const std::stop_token& stop) const;

 private:
  /// What a feature may be the same as.
  struct Candidate {
    FeatureIndex feature;
    double confusable = 0.0;      // other features that it may be mistaken for
    PointMatrix<Dim> covariance;  // of the difference
  };
  /// Features of a map with candidates.
  struct Open {
    std::vector<FeatureIndex> features;
    std::vector<std::vector<Candidate>> candidates;
    std::vector<FeatureIndex> with_near;  // these features and all that lie near one of them, ascending
    Eigen::MatrixXd covariances;          // a row for each coordinate of `features`, a column for each of `with_near`

    /// Of one of `with_near`, its rows, and features[place], its columns.
    PointMatrix<Dim> covariance(FeatureIndex one, std::size_t place) const;
  };

  Open open_features(std::size_t map, bool only_neighbours) const;
  std::vector<FeatureIndex> near(FeatureIndex feature, std::size_t map, bool only_neighbours) const;
  std::vector<MapPair<Dim>> pairs_of(std::size_t map, double reach) const;
  Proposals of_map(std::size_t map, double reach, bool only_neighbours) const;
  Proposals of_pair(std::size_t earlier, std::size_t later, const Open& open, double reach, Matcher<Dim>& matcher) const;
  Proposals within(std::size_t map, const Open& open, Matcher<Dim>& matcher) const;
  PairingProblem<Dim> problem(const std::vector<FeatureIndex>& known, const std::vector<std::size_t>& open_places,
                              const Open& open, std::size_t known_map) const;
  std::vector<Variable> variables_of(const std::vector<FeatureIndex>& features) const;
  Eigen::MatrixXd joint(const std::vector<FeatureIndex>& features, std::size_t map) const;
  const Point<Dim>& position(FeatureIndex feature) const { return estimate_.covariances->state().features[feature]; }
  bool is_in(FeatureIndex feature, std::size_t map) const;

  const FeatureEstimate<Dim>& estimate_;
  const Identities& identities_;
  const NeighbourDensity<Dim>& density_;
  AssociationMethod method_;
  double confidence_;
  double scale_;
  double gate_;
  Table<FeatureIndex, PointMatrix<Dim>> covariances_;
  double largest_ = 0.0;  // trace of a covariance
  PointTree<Dim> tree_;
};

}  // namespace mapjoin
