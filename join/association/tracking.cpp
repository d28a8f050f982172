// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/association/feature_filter.hpp>
#include <mapjoin/join/association/tracking.hpp>
#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <numeric>
#include <span>

namespace mapjoin {
namespace {

template <int Dim>
class Tracker {
 public:
  Tracker(Matcher<Dim>& matcher, double confidence) : matcher_(matcher), confidence_(confidence) {}

  void move(const PoseFactor<Dim>& step) { filter_.move(step); }

  /// Takes the observations of one pose.
  void see(std::span<const FeatureFactor<Dim>> scan) {
    const std::vector<Match> matches = matcher_(problem(scan));
    std::vector<std::size_t> fresh;
    for (std::size_t s = 0; s < scan.size(); ++s) {
      const Match& match = matches[s];
      if (match.known && match.probability >= confidence_) {
        tracked_.push_back({features_[*match.known], match});
        filter_.update(*match.known, scan[s]);
        continue;
      }
      tracked_.push_back({next_++, std::nullopt});
      if (match.candidates == 0) fresh.push_back(s);
    }
    for (const std::size_t s : fresh) {
      filter_.add(scan[s]);
      features_.push_back(tracked_[tracked_.size() - scan.size() + s].feature);
    }
  }

  std::vector<Tracked> take() { return std::move(tracked_); }

 private:
  PairingProblem<Dim> problem(std::span<const FeatureFactor<Dim>> scan) const {
    PairingProblem<Dim> problem;
    problem.known = filter_.features();
    const Eigen::Index known = filter_.covariance().rows();
    const Eigen::Index rows = known + static_cast<Eigen::Index>(scan.size()) * Dim;
    problem.covariance.setZero(rows, rows);
    problem.covariance.topLeftCorner(known, known) = filter_.covariance();
    std::vector<std::size_t> all(problem.known.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    problem.choices.assign(scan.size(), all);
    for (std::size_t s = 0; s < scan.size(); ++s) {
      problem.sightings.push_back(scan[s].measured);
      const Eigen::Index row = known + static_cast<Eigen::Index>(s) * Dim;
      problem.covariance.template block<Dim, Dim>(row, row) = covariance_of(scan[s].information);
    }
    return problem;
  }

  Matcher<Dim>& matcher_;
  double confidence_;
  FeatureFilter<Dim> filter_;
  std::vector<std::size_t> features_;  // numbers of the features in the filter
  std::vector<Tracked> tracked_;
  std::size_t next_ = 0;
};

}  // namespace

template <int Dim>
std::vector<Tracked> track(const SegmentView<Dim>& segment, Matcher<Dim>& matcher, double confidence) {
  Tracker<Dim> tracker(matcher, confidence);
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

template std::vector<Tracked> track(const SegmentView<2>&, Matcher<2>&, double);
template std::vector<Tracked> track(const SegmentView<3>&, Matcher<3>&, double);

}  // namespace mapjoin
