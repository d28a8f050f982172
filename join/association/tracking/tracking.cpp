// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/association/tracking/feature_filter.hpp>
#include <mapjoin/join/association/tracking/tracking.hpp>
#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <numeric>
#include <span>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
class Tracker {
 public:
  Tracker(const SightingChance& sees, Matcher<Dim>& matcher, double confidence)
      : sees_(sees), matcher_(matcher), confidence_(confidence) {}

  void move(const PoseFactor<Dim>& step) { filter_.move(step); }

  /// Takes the observations of one pose.
  void see(std::span<const FeatureFactor<Dim>> scan) {
    if (scan.empty()) return;
    const std::vector<Match> matches = matcher_(problem(scan));
    note_trials(matches);
    std::vector<std::size_t> fresh;
    for (std::size_t s = 0; s < scan.size(); ++s) {
      const Match& match = matches[s];
      if (match.known && match.probability >= confidence_) {
        Feature& feature = features_[*match.known];
        tracks_.observations.push_back({feature.number, match});
        feature.distance = scan[s].measured.norm();
        feature.is_seen_again = true;
        filter_.update(*match.known, scan[s]);
        continue;
      }
      tracks_.observations.push_back({next_++, std::nullopt});
      if (match.candidates == 0) fresh.push_back(s);
    }
    for (const std::size_t s : fresh) {
      filter_.add(scan[s]);
      const std::size_t number = tracks_.observations[tracks_.observations.size() - scan.size() + s].feature;
      features_.push_back({number, scan[s].measured.norm(), false});
    }
  }

  Tracks<Dim> take() {
    for (std::size_t k = 0; k < features_.size(); ++k) {
      if (features_[k].is_seen_again) tracks_.followed.push_back(filter_.features()[k]);
    }
    return std::move(tracks_);
  }

 private:
  /// A feature in the filter.
  struct Feature {
    std::size_t number;
    double distance;     // from the pose that saw it last (m)
    bool is_seen_again;  // true once it was seen twice
  };

  void note_trials(const std::vector<Match>& matches) {
    for (std::size_t k = 0; k < features_.size(); ++k) {
      const bool is_seen = std::ranges::any_of(matches, [k](const Match& match) { return match.known == k; });
      tracks_.trials.emplace_back(filter_.features()[k].norm(), is_seen);
    }
  }

  PairingProblem<Dim> problem(std::span<const FeatureFactor<Dim>> scan) const {
    PairingProblem<Dim> problem;
    problem.known = filter_.features();
    const Eigen::Index known = filter_.covariance().rows();
    const Eigen::Index rows = problem.row_of_sighting(scan.size());
    problem.covariance.setZero(rows, rows);
    problem.covariance.topLeftCorner(known, known) = filter_.covariance();
    problem.sees = &sees_;
    for (std::size_t k = 0; k < features_.size(); ++k) {
      problem.distances.push_back({features_[k].distance, problem.known[k].norm()});
    }
    std::vector<std::size_t> all(problem.known.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    problem.choices.assign(scan.size(), all);
    for (std::size_t s = 0; s < scan.size(); ++s) {
      problem.sightings.push_back(scan[s].measured);
      const Eigen::Index row = problem.row_of_sighting(s);
      problem.covariance.template block<Dim, Dim>(row, row) = covariance_of(scan[s].information);
    }
    return problem;
  }

  const SightingChance& sees_;
  Matcher<Dim>& matcher_;
  double confidence_;
  FeatureFilter<Dim> filter_;
  std::vector<Feature> features_;  // the features in the filter
  Tracks<Dim> tracks_;
  std::size_t next_ = 0;
};

}  // namespace

template <int Dim>
Tracks<Dim> track(const SegmentView<Dim>& segment, const SightingChance& sees, Matcher<Dim>& matcher, double confidence) {
  Tracker<Dim> tracker(sees, matcher, confidence);
  auto step = segment.odometry.begin();
  auto first = segment.observations.begin();
  for (PoseIndex pose = segment.begin; pose <= segment.end; ++pose) {
    // Only the first of repeated edges counts.
    for (bool has_moved = false; step != segment.odometry.end() && later_pose(*step) == pose; ++step) {
      if (!std::exchange(has_moved, true)) tracker.move(*step);
    }
    const auto last = std::find_if(first, segment.observations.end(), [&](const auto& o) { return o.base != pose; });
    tracker.see(segment.observations.subspan(static_cast<std::size_t>(first - segment.observations.begin()),
                                             static_cast<std::size_t>(last - first)));
    first = last;
  }
  return tracker.take();
}

template Tracks<2> track(const SegmentView<2>&, const SightingChance&, Matcher<2>&, double);
template Tracks<3> track(const SegmentView<3>&, const SightingChance&, Matcher<3>&, double);

}  // namespace mapjoin
