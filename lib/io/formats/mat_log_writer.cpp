// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/formats/covariance_weights.hpp>
#include <mapjoin/io/formats/mat_log.hpp>
#include <mapjoin/io/g2o/numbering.hpp>

namespace mapjoin {
namespace {

constexpr double kOdometryRow = 1.0;
constexpr double kObservationRow = 0.0;

/// The rows of the table, one after the other; the first fault counts.
class Table {
 public:
  Table(const Log<2>& log, const G2oNumbering& numbering) : log_(log), numbering_(numbering) {
    rows_.setZero(static_cast<Eigen::Index>(log.edges().size() + log.observations().size()), 12);
  }

  void add(const PoseFactor<2>& edge) {
    auto row = begin_row(kOdometryRow, numbering_(pose(edge.base)), numbering_(pose(edge.target)));
    Matrix<3> P = Matrix<3>::Zero();
    note(covariance_of(edge.information, P));
    row.segment<3>(3) << edge.measured.translation.transpose(), edge.measured.rotation.angle();
    row.tail<6>() << P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2);
  }
  void add(const FeatureFactor<2>& o) {
    auto row = begin_row(kObservationRow, numbering_(pose(o.base)), log_.features[static_cast<std::size_t>(o.target)].key);
    Matrix<2> P = Matrix<2>::Zero();
    note(covariance_of(o.information, P));
    row.segment<2>(3) = o.measured.transpose();
    row.segment<3>(5) << P(0, 0), P(0, 1), P(1, 1);
  }

  const Eigen::MatrixXd& rows() const { return rows_; }
  const Fault& fault() const { return fault_; }

 private:
  Eigen::MatrixXd::RowXpr begin_row(double kind, std::uint64_t base, std::uint64_t target) {
    base_ = base;
    target_ = target;
    constexpr auto kEnd = static_cast<std::uint64_t>(kDoubleIdEnd);
    if (std::max(base, target) >= kEnd) note("has an id of 2^53 or more");
    auto row = rows_.row(next_++);
    row.head<3>() << kind, static_cast<double>(base), static_cast<double>(target);
    return row;
  }
  void note(const Fault& fault) {
    if (fault && !fault_) {
      fault_ = fmt::format("{}: the edge {}-{} {}, which a MAT file cannot say", log_.source, base_, target_, *fault);
    }
  }
  PoseId pose(Index index) const { return log_.poses[static_cast<std::size_t>(index)]; }

  const Log<2>& log_;
  G2oNumbering numbering_;
  Eigen::MatrixXd rows_;
  Eigen::Index next_ = 0;
  std::uint64_t base_ = 0;
  std::uint64_t target_ = 0;
  Fault fault_;
};

}  // namespace

Expected<void> write_mat_log(const Log<2>& log, const std::filesystem::path& path) {
  const auto numbering = number_for_g2o(log.poses, {});
  if (!numbering) return tl::unexpected(numbering.error());
  Table table(log, *numbering);
  for (const auto& edge : log.edges()) table.add(edge);
  for (const auto& observation : log.observations()) table.add(observation);
  if (table.fault()) return tl::unexpected(Error{ErrorKind::kUsage, *table.fault()});
  return write_file(path, mat_bytes({{"VicPark_clean_data", table.rows()}}));
}

}  // namespace mapjoin
