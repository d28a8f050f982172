// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <numbers>
#include <tests/support/data.hpp>
#include <tests/support/victoria_park_raw.hpp>
#include <utility>

namespace mapjoin::testing {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kWheelbase = 2.83;
constexpr double kToEncoder = 0.76;
const Point<2> kLaser(3.78, 0.5);
/// The time of scan n is kFirstScan + n kScanPeriod (s).
constexpr double kFirstScan = 21.82065;
constexpr double kScanPeriod = 0.2136294;

Eigen::MatrixXd read(const std::string& file, const std::string& variable) {
  const auto path = data_file(file);
  const auto bytes = FileBytes::read(path).value();
  return read_mat(bytes.view(), path.string(), {variable}).value().at(variable);
}

/// The motion of the middle of the rear axle, and its covariance.
class Drive {
 public:
  Drive() : rows_(read("vicpark-6898/ControlData.mat", "ControlData")) { rows_.col(0) *= 1e-3; }

  double end() const { return rows_(rows_.rows() - 1, 0); }
  std::pair<Pose<2>, Matrix<3>> between(double begin, double end) {
    Pose<2> moved;
    Matrix<3> P = Matrix<3>::Zero();
    while (begin < end) {
      while (at_ + 1 < rows_.rows() && rows_(at_ + 1, 0) <= begin) ++at_;
      const double until = at_ + 1 < rows_.rows() ? std::min(end, rows_(at_ + 1, 0)) : end;
      move(until - begin, moved, P);
      begin = until;
    }
    return {moved, P};
  }

 private:
  void move(double seconds, Pose<2>& moved, Matrix<3>& P) const {
    const double steering = rows_(at_, 2);
    const double speed = rows_(at_, 1) / (1.0 - std::tan(steering) * kToEncoder / kWheelbase);
    const double way = seconds * speed;
    const double turned = way * std::tan(steering) / kWheelbase;
    const Pose<2> step{way * Point<2>(std::cos(0.5 * turned), std::sin(0.5 * turned)), Rotation<2>(turned)};
    Eigen::Matrix<double, 3, 2> J_controls;
    J_controls << seconds, 0.0, 0.0, 0.0, seconds * std::tan(steering) / kWheelbase,
        way / kWheelbase / (std::cos(steering) * std::cos(steering));
    const Vector<2> controls(0.02, 2.0 * kDegree);
    const Vector<3> besides(0.2, 0.2, kDegree);
    Matrix<3> Q = J_controls * controls.cwiseAbs2().asDiagonal() * J_controls.transpose();
    Q += (seconds * besides.cwiseAbs2()).asDiagonal();
    Matrix<3> J_before, J_step;
    moved = compose(moved, step, &J_before, &J_step);
    P = J_before * P * J_before.transpose() + J_step * Q * J_step.transpose();
  }

  Eigen::MatrixXd rows_;  // time (s), speed of the wheel (m/s), steering (rad)
  Eigen::Index at_ = 0;
};

void observe(PoseId pose, FeatureId tree, double range, double bearing, LogBuilder<2>& builder) {
  const Point<2> along(std::cos(bearing), std::sin(bearing));
  Matrix<2> R;
  R << along.x(), -along.y(), along.y(), along.x();
  const Vector<2> deviations(0.1 + 0.01 * range, range * kDegree);
  const Matrix<2> W = R * deviations.cwiseAbs2().cwiseInverse().asDiagonal() * R.transpose();
  builder.add_observation(pose, tree, kLaser + range * along, 0.5 * (W + W.transpose()));
}

}  // namespace

Log<2> victoria_park_raw() {
  const Eigen::MatrixXd ranges = read("vicpark-raw/lidar_measurements.mat", "lidar_ranges");
  const Eigen::MatrixXd bearings = read("vicpark-raw/lidar_measurements.mat", "lidar_bearings");
  Drive drive;
  LogBuilder<2> builder("vicpark-raw");
  PoseId pose{0, 0};
  double last = kFirstScan;
  std::uint64_t trees = 0;
  for (Eigen::Index scan = 0; scan < ranges.rows(); ++scan) {
    const double time = kFirstScan + kScanPeriod * static_cast<double>(scan);
    if (time > drive.end() || !(ranges.row(scan).array() > 0.0).any()) continue;
    if (trees > 0) {
      const auto [moved, P] = drive.between(last, time);
      const PoseId next{0, pose.key + 1};
      builder.add_pose_edge(pose, next, moved, information_of_covariance<3>(0.5 * (P + P.transpose())).value());
      pose = next;
    }
    last = time;
    builder.add_stamp(pose, std::llround(1e9 * time));
    for (Eigen::Index k = 0; k < ranges.cols(); ++k) {
      // Bearings are counted from the right-hand side.
      if (ranges(scan, k) > 0.0) observe(pose, {trees++}, ranges(scan, k), bearings(scan, k) - 90.0 * kDegree, builder);
    }
  }
  return std::move(builder).finish().value();
}

double median_distance_from_gps(const Log<2>& log, const Table<PoseIndex, Pose<2>>& poses) {
  const Eigen::VectorXd times = 1e-3 * read("vicpark-raw/aa3_gpsx.mat", "timeGps").col(0);
  const Eigen::VectorXd east = read("vicpark-raw/aa3_gpsx.mat", "Lo_m").col(0);
  const Eigen::VectorXd north = read("vicpark-raw/aa3_gpsx.mat", "La_m").col(0);
  const auto stamp = [&](PoseIndex p) { return 1e-9 * static_cast<double>(log.stamps_ns[p]); };
  struct Place {
    Pose<2> pose;
    Point<2> fix;
  };
  std::vector<Place> places;
  PoseIndex p(0);
  for (Eigen::Index k = 0; k < times.size(); ++k) {
    while (p.position() + 2 < poses.size() && stamp(p + 1) < times[k]) ++p;
    const double share = (times[k] - stamp(p)) / (stamp(p + 1) - stamp(p));
    if (share < 0.0 || share > 1.0) continue;
    const Pose<2> step = between(poses[p], poses[p + 1]);
    const Pose<2> moved{share * step.translation, Rotation<2>(share * step.rotation.log()[0])};
    places.push_back({compose(poses[p], moved), {east[k], north[k]}});
  }
  // Gauss-Newton over the turn a, R(a) lever and the offset; each fix is weighted by the inverse of its distance.
  double turn = 0.0;
  Point<2> lever = Point<2>::Zero();
  Point<2> offset = Point<2>::Zero();
  std::vector<double> distances(places.size(), 1.0);
  for (int round = 0; round < 50; ++round) {
    Matrix<5> A = Matrix<5>::Zero();
    Vector<5> b = Vector<5>::Zero();
    for (std::size_t k = 0; k < places.size(); ++k) {
      const Matrix<2> R = places[k].pose.rotation.matrix();
      const Point<2> x = Rotation<2>(turn).matrix() * places[k].pose.translation;
      const Point<2> missing = places[k].fix - x - R * lever - offset;
      distances[k] = missing.norm();
      Eigen::Matrix<double, 2, 5> J;
      J << Point<2>(-x.y(), x.x()), R, Matrix<2>::Identity();
      A += J.transpose() * J / std::max(0.1, distances[k]);
      b += J.transpose() * missing / std::max(0.1, distances[k]);
    }
    const Vector<5> step = A.ldlt().solve(b);
    turn += step[0];
    lever += step.segment<2>(1);
    offset += step.tail<2>();
  }
  return median(distances);
}

}  // namespace mapjoin::testing
