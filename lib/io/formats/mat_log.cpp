// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/formats/mat_log.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/log_builder.hpp>

namespace mapjoin {
namespace {

constexpr const char* kVictoriaPark = "VicPark_clean_data";
constexpr const char* kDlr = "corrected_data_circles";
/// In the first column of the DLR data: the row is a step.
constexpr double kDlrStep = -100.0;
constexpr double kUnassociated = -1.0;

/// What a row of the table says, or what is wrong with it in words; the first fault counts.
class Row {
 public:
  Row(const Eigen::MatrixXd& table, Eigen::Index row, InformationCheck& check) : table_(table), row_(row), check_(check) {
    if (!table.row(row).allFinite()) fault_ = "a value is not finite";
  }

  double operator[](Eigen::Index col) const { return table_(row_, col); }

  std::uint64_t id(Eigen::Index col) {
    const auto id = id_of((*this)[col]);
    if (!id) fail(fmt::format("column {}: {} is not an id", col + 1, (*this)[col]));
    return id.value_or(0);
  }
  PoseId pose(Eigen::Index col) { return {0, id(col)}; }
  FeatureId feature(Eigen::Index col) { return {id(col)}; }

  Point<2> point(Eigen::Index col) const { return {(*this)[col], (*this)[col + 1]}; }
  Pose<2> motion(Eigen::Index col) const { return {point(col), Rotation<2>((*this)[col + 2])}; }

  template <int Size>
  Matrix<Size> information(Matrix<Size> covariance) {
    if (const auto fault = check_.invert<Size>(covariance)) fail("the covariance " + *fault);
    return covariance;
  }

  void fail(std::string fault) {
    if (fault_.empty()) fault_ = std::move(fault);
  }
  const std::string& fault() const { return fault_; }

 private:
  const Eigen::MatrixXd& table_;
  Eigen::Index row_;
  InformationCheck& check_;
  std::string fault_;
};

Matrix<2> symmetric(double xx, double xy, double yy) {
  return (Matrix<2>() << xx, xy, xy, yy).finished();
}

Matrix<3> symmetric(double xx, double xy, double xphi, double yy, double yphi, double phiphi) {
  return (Matrix<3>() << xx, xy, xphi, xy, yy, yphi, xphi, yphi, phiphi).finished();
}

void add_victoria_park_row(Row& row, LogBuilder<2>& builder) {
  if (row[0] == 1.0) {
    const Matrix<3> P = symmetric(row[6], row[7], row[8], row[9], row[10], row[11]);
    builder.add_pose_edge(row.pose(1), row.pose(2), row.motion(3), row.information<3>(P));
  } else if (row[0] == 0.0) {
    const Matrix<2> P = symmetric(row[5], row[6], row[7]);
    builder.add_observation(row.pose(1), row.feature(2), row.point(3), row.information<2>(P));
  } else {
    row.fail(fmt::format("begins with {}, which is neither 1 (odometry) nor 0 (observation)", row[0]));
  }
}

/// `step` is the pose that the rows speak of; `unassociated` counts observations.
void add_dlr_row(Row& row, LogBuilder<2>& builder, std::uint64_t& step, std::int64_t& unassociated) {
  if (row[0] == kDlrStep) {
    const Matrix<3> P = symmetric(row[4], row[5], row[7], row[6], row[8], row[9]);
    builder.add_pose_edge({0, step}, {0, step + 1}, row.motion(1), row.information<3>(P));
    ++step;
  } else if (row[6] == kUnassociated) {
    ++unassociated;
  } else {
    const Matrix<2> P = symmetric(row[3], row[4], row[5]);
    builder.add_observation({0, step}, row.feature(6), row.point(0), row.information<2>(P));
  }
}

/// Hands every row of the table to `add`; the first fault ends it.
template <typename AddRow>
Expected<void> add_rows(const std::string& file, const char* variable, const Eigen::MatrixXd& table, Eigen::Index cols,
                        InformationCheck& check, const AddRow& add) {
  if (table.cols() != cols) {
    return bad_input(fmt::format("{}: variable {} has {} columns, not {}", file, variable, table.cols(), cols));
  }
  for (Eigen::Index i = 0; i < table.rows(); ++i) {
    Row row(table, i, check);
    add(row);
    if (!row.fault().empty()) {
      return bad_input(fmt::format("{}: variable {}, row {}: {}", file, variable, i + 1, row.fault()));
    }
  }
  return {};
}

Expected<Log<2>> victoria_park(const std::string& file, const Eigen::MatrixXd& table, InformationCheck& check) {
  LogBuilder<2> builder(file);
  return add_rows(file, kVictoriaPark, table, 12, check, [&](Row& row) { add_victoria_park_row(row, builder); }).and_then([&] {
    return std::move(builder).finish();
  });
}

Expected<Log<2>> dlr(const std::string& file, const Eigen::MatrixXd& table, InformationCheck& check) {
  LogBuilder<2> builder(file);
  std::uint64_t step = 0;
  std::int64_t unassociated = 0;
  const auto added = add_rows(file, kDlr, table, 10, check, [&](Row& row) { add_dlr_row(row, builder, step, unassociated); });
  if (!added) return tl::unexpected(added.error());
  auto log = std::move(builder).finish();
  if (log) log->unassociated = unassociated;
  return log;
}

}  // namespace

Expected<AnyLog> read_mat_log(std::string_view bytes, const std::string& file, const ReadOptions& options) {
  const auto variables = read_mat(bytes, file, {kVictoriaPark, kDlr});
  if (!variables) return tl::unexpected(variables.error());
  InformationCheck check(options.repair_information);
  const auto to_any = [&](Log<2>&& log) {
    log.conventions.repairs = check.repairs();
    return AnyLog(std::move(log));
  };
  if (const auto found = variables->find(kVictoriaPark); found != variables->end()) {
    return victoria_park(file, found->second, check).map(to_any);
  }
  if (const auto found = variables->find(kDlr); found != variables->end()) return dlr(file, found->second, check).map(to_any);
  return bad_input(fmt::format("{}: holds neither the variable {} nor {}", file, kVictoriaPark, kDlr));
}

}  // namespace mapjoin
