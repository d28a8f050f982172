// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/simulate/lattice_walk.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <stdexcept>
#include <unordered_map>

namespace mapjoin {
namespace {

/// The random streams, one for each purpose: a change of one leaves the others alone.
enum ManhattanStream : std::uint64_t { kPath, kOdometry, kObservation, kFeatures };

/// The hash of a cell of the feature grid, also the random stream of its feature.
template <int Dim>
struct CellHash {
  std::uint64_t operator()(const LatticePoint<Dim>& cell) const {
    std::uint64_t hash = kFeatures;
    for (int axis = 0; axis < Dim; ++axis) hash = mix(hash + static_cast<std::uint64_t>(cell[axis])) + 1;
    return hash;
  }
};

template <int Dim>
LatticeBox<Dim> box_of(const ManhattanOptions& options) {
  const double side = options.side.value_or(2.0 * std::sqrt(static_cast<double>(options.poses) / 5.0));
  const auto blocks = std::max<std::int64_t>(1, whole_part(side / options.block));
  LatticeBox<Dim> box{LatticePoint<Dim>::Constant(-(blocks / 2)), LatticePoint<Dim>::Constant(blocks - blocks / 2)};
  if constexpr (Dim == 3) {
    box.low.z() = 0;
    box.high.z() = options.storeys - 1;
  }
  return box;
}

template <int Dim>
class Simulator {
 public:
  explicit Simulator(const ManhattanOptions& options)
      : options_(options),
        observation_sigma_(Point<Dim>::Constant(options.observation_noise)),
        walk_(std::llround(options.block / options.step), box_of<Dim>(options), RandomStream(options.seed, kPath)),
        odometry_random_(options.seed, kOdometry),
        observation_random_(options.seed, kObservation),
        begin_(static_cast<std::size_t>(options.poses * (options.part - 1) / options.parts)),
        end_(static_cast<std::size_t>(options.poses * options.part / options.parts)),
        first_(begin_ - std::min<std::size_t>(begin_, 1)) {
    step_sigma_.template head<Dim>().setConstant(options.step_noise);
    step_sigma_.template tail<kRotationDof<Dim>>().setConstant(options.turn_noise);
  }

  Simulation<Dim> run(const std::stop_token& stop) && {
    Log<Dim>& log = result_.log;
    GlobalMap<Dim>& truth = result_.truth;
    const std::size_t poses = end_ - first_;
    log.source = fmt::format("simulated Manhattan world, seed {}", options_.seed);
    log.poses.reserve(poses);
    truth.poses.reserve(poses);
    log.graph.pose_factors.reserve(poses - 1);
    for (std::size_t i = 0; i < end_ && (i == 0 || !stop.stop_requested()); ++i) {
      if (i > 0) {
        const LatticeRotation<Dim> before = walk_.rotation();
        walk_.advance();
        add_odometry(i, before.transpose() * walk_.rotation());
      }
      if (i >= first_) add_pose(i);
      observe_around(i);
    }
    take_features();
    log.sessions = {{0, PoseIndex(log.poses.size())}};
    if (begin_ == 0) log.graph.fixed = {{0, Pose<Dim>{}}};
    if (begin_ == 0) truth.gauge = {0};
    truth.pose_ids = log.poses;
    truth.feature_ids = log.features;
    return std::move(result_);
  }

 private:
  Point<Dim> position() const { return options_.step * walk_.position().template cast<double>(); }

  void add_pose(std::size_t i) {
    result_.log.poses.push_back({0, i});
    result_.truth.poses.push_back({position(), to_rotation(walk_.rotation())});
  }

  void add_odometry(std::size_t i, const LatticeRotation<Dim>& turn) {
    const Pose<Dim> step{options_.step * Point<Dim>::UnitX(), to_rotation(turn)};
    const Pose<Dim> measured = retract(step, noise(odometry_random_, step_sigma_));
    if (i < begin_) return;
    const PoseIndex pose(i - first_);
    result_.log.graph.pose_factors.push_back({pose - 1, pose, measured, step_sigma_.cwiseAbs2().cwiseInverse().asDiagonal()});
  }

  void observe_around(std::size_t i) {
    const Point<Dim> position = this->position();
    const double reach = options_.range + options_.feature_jitter;
    // Cell k has its centre at (k + 1/2) times its side.
    LatticePoint<Dim> low, high;
    for (int axis = 0; axis < Dim; ++axis) {
      low[axis] = static_cast<std::int64_t>(std::ceil((position[axis] - reach) / options_.feature_cell - 0.5));
      high[axis] = static_cast<std::int64_t>(std::floor((position[axis] + reach) / options_.feature_cell - 0.5));
    }
    if ((low.array() > high.array()).any()) return;
    // Every cell of the box [low, high], the first axis running fastest.
    for (LatticePoint<Dim> cell = low; cell[Dim - 1] <= high[Dim - 1];) {
      const Point<Dim> feature = feature_in(cell);
      if ((feature - position).norm() <= options_.range) observe(i, cell, feature);
      ++cell[0];
      for (int axis = 0; axis + 1 < Dim && cell[axis] > high[axis]; ++axis) {
        cell[axis] = low[axis];
        ++cell[axis + 1];
      }
    }
  }

  void observe(std::size_t i, const LatticePoint<Dim>& cell, const Point<Dim>& feature) {
    if (options_.chance < 1.0 && observation_random_.uniform(0.0, 1.0) >= options_.chance) return;
    const auto [entry, is_new] = features_.try_emplace(cell, places_.size());
    if (is_new) places_.push_back(feature);
    const Point<Dim> seen = walk_.rotation().transpose().template cast<double>() * (feature - position());
    const Point<Dim> measured = seen + noise(observation_random_, observation_sigma_);
    if (i < begin_) return;
    result_.log.graph.feature_factors.push_back(
        {PoseIndex(i - first_), entry->second, measured, observation_sigma_.cwiseAbs2().cwiseInverse().asDiagonal()});
  }

  /// Takes the features that the part has seen, of all that were seen.
  void take_features() {
    Table<FeatureIndex, FeatureIndex> own(places_.size(), -1);
    auto& observations = result_.log.graph.feature_factors;
    for (const auto& o : observations) own[o.target] = 0;
    for (const FeatureIndex f : indices(places_)) {
      if (own[f] == -1) continue;
      own[f] = FeatureIndex(result_.log.features.size());
      result_.log.features.push_back({first_feature_id() + f.position()});
      result_.truth.features.push_back(places_[f]);
    }
    for (auto& o : observations) o.target = own[o.target];
  }

  /// The first feature id: 0 or, with several parts, that of g2o's joint numbering after the poses, a power of ten that is at
  /// least their number.
  std::uint64_t first_feature_id() const {
    std::uint64_t first = options_.parts > 1 ? 1 : 0;
    while (options_.parts > 1 && first < static_cast<std::uint64_t>(options_.poses)) first *= 10;
    return first;
  }

  Point<Dim> feature_in(const LatticePoint<Dim>& cell) const {
    RandomStream random(options_.seed, CellHash<Dim>{}(cell));
    Point<Dim> feature;
    for (int axis = 0; axis < Dim; ++axis) {
      feature[axis] = options_.feature_cell * (static_cast<double>(cell[axis]) + 0.5) +
                      random.uniform(-options_.feature_jitter, options_.feature_jitter);
    }
    return feature;
  }

  template <int Rows>
  Vector<Rows> noise(RandomStream& random, const Vector<Rows>& sigma) const {
    Vector<Rows> w;
    for (int row = 0; row < Rows; ++row) w[row] = options_.noise_multiplier * sigma[row] * random.normal();
    return w;
  }

  const ManhattanOptions& options_;
  PoseVector<Dim> step_sigma_;
  Point<Dim> observation_sigma_;
  LatticeWalk<Dim> walk_;
  RandomStream odometry_random_;
  RandomStream observation_random_;
  std::size_t begin_;  // poses [begin_, end_) of the part
  std::size_t end_;
  std::size_t first_;  // the pose that the part's first edge comes from
  std::unordered_map<LatticePoint<Dim>, FeatureIndex, CellHash<Dim>> features_;
  Table<FeatureIndex, Point<Dim>> places_;
  Simulation<Dim> result_;
};

}  // namespace

std::vector<std::string> ManhattanOptions::validate() const {
  std::vector<std::string> violations;
  const auto require = [&](bool holds, std::string_view what) {
    if (!holds) violations.emplace_back(what);
  };
  const auto is_length = [](double x) { return x >= 1e-3 && x <= 1e3; };
  const auto is_deviation = [](double x) { return x >= 1e-9 && x <= 1e3; };
  require(poses >= 1 && poses <= kMostPoses, fmt::format("poses must be between 1 and {}", kMostPoses));
  require(part >= 1 && part <= parts && parts <= std::max<std::int64_t>(1, poses),
          "part must be one of the parts, of a pose each at least");
  require(is_length(step), "step must lie between a millimetre and a kilometre");
  require(is_length(block), "block must lie between a millimetre and a kilometre");
  const double steps = block / step;
  require(steps >= 0.5 && steps <= 1e6 && whole_part(steps) >= 1 && is_whole(steps),
          "block must be a whole number of steps, at most a million");
  require(!side || (*side > 0.0 && *side <= 1e6 * block), "side must be above 0 and at most a million blocks");
  require(storeys >= 1 && storeys <= 1'000'000, "storeys must be between 1 and a million");
  require(is_length(feature_cell), "feature cell must lie between a millimetre and a kilometre");
  require(feature_jitter >= 0.0 && feature_jitter <= 0.5 * feature_cell, "feature jitter must lie between 0 and half a cell");
  require(range >= 0.0 && range <= 20.0 * feature_cell, "range must lie between 0 and 20 feature cells");
  require(chance >= 0.0 && chance <= 1.0, "chance must lie between 0 and 1");
  require(is_deviation(step_noise), "step noise must lie between 1e-9 and 1000 m");
  require(is_deviation(turn_noise), "turn noise must lie between 1e-9 and 1000 rad");
  require(is_deviation(observation_noise), "observation noise must lie between 1e-9 and 1000 m");
  require(noise_multiplier >= 0.0 && noise_multiplier <= 1e6, "noise multiplier must lie between 0 and a million");
  return violations;
}

template <int Dim>
Simulation<Dim> simulate_manhattan(const ManhattanOptions& options, const std::stop_token& stop) {
  const auto violations = options.validate();
  if (!violations.empty()) throw std::invalid_argument(fmt::format("{}", fmt::join(violations, "; ")));
  return Simulator<Dim>(options).run(stop);
}

template Simulation<2> simulate_manhattan(const ManhattanOptions&, const std::stop_token&);
template Simulation<3> simulate_manhattan(const ManhattanOptions&, const std::stop_token&);

}  // namespace mapjoin
