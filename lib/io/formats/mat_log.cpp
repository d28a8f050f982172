// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/geometry/upper_triangle.hpp>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/formats/edge_text.hpp>
#include <mapjoin/io/formats/mat_log.hpp>
#include <mapjoin/io/g2o/numbering.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/log_builder.hpp>

namespace mapjoin {
namespace {

constexpr const char* kVictoriaPark = "VicPark_clean_data";
constexpr const char* kPosesOfMap = "poses";  // as write_mat_map() names them
constexpr const char* kDlr = "corrected_data_circles";
constexpr double kOdometry = 1.0;
constexpr double kObservation = 0.0;
/// The mark of a step in the first column of the DLR data.
constexpr double kDlrStep = -100.0;
constexpr double kUnassociated = -1.0;

/// A row of the table, and its first fault in words, if any.
class TableRow {
 public:
  TableRow(const Eigen::MatrixXd& table, Eigen::Index row, InformationCheck& check) : table_(table), row_(row), check_(check) {
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

  /// The information matrix of the covariance whose upper triangle begins in this column, row by row or column by column.
  template <int Size>
  Matrix<Size> information(Eigen::Index col, bool by_columns = false) {
    Matrix<Size> P;
    for (int i = 0; i < Size; ++i) {
      for (int j = by_columns ? 0 : i; j < (by_columns ? i + 1 : Size); ++j) P(i, j) = P(j, i) = (*this)[col++];
    }
    if (const auto fault = check_.invert<Size>(P)) fail("the covariance " + *fault);
    return P;
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

void add_victoria_park_row(TableRow& row, LogBuilder<2>& builder) {
  if (row[0] == kOdometry) {
    builder.add_pose_edge(row.pose(1), row.pose(2), row.motion(3), row.information<3>(6));
  } else if (row[0] == kObservation) {
    builder.add_observation(row.pose(1), row.feature(2), row.point(3), row.information<2>(5));
  } else {
    row.fail(fmt::format("begins with {}, which is neither 1 (odometry) nor 0 (observation)", row[0]));
  }
}

/// Adds a row of the DLR data; `step` is the pose to which the last step led.
void add_dlr_row(TableRow& row, LogBuilder<2>& builder, std::uint64_t& step) {
  if (row[0] == kDlrStep) {
    builder.add_pose_edge({0, step}, {0, step + 1}, row.motion(1), row.information<3>(4, true));
    ++step;
  } else if (row[6] == kUnassociated) {
    builder.add_unassociated();
  } else {
    builder.add_observation({0, step}, row.feature(6), row.point(0), row.information<2>(3));
  }
}

/// The log of a table, each row of which `add` hands to a builder; the first fault ends it.
template <typename AddRow>
Expected<AnyLog> log_of(const std::string& file, const char* variable, const Eigen::MatrixXd& table, Eigen::Index cols,
                        const ReadOptions& options, const AddRow& add) {
  if (table.cols() != cols) {
    return bad_input(fmt::format("{}: variable {} has {} columns, not {}", file, variable, table.cols(), cols));
  }
  InformationCheck check(options.repair_information);
  LogBuilder<2> builder(file);
  for (Eigen::Index i = 0; i < table.rows(); ++i) {
    TableRow row(table, i, check);
    add(row, builder);
    if (!row.fault().empty()) {
      return bad_input(fmt::format("{}: variable {}, row {}: {}", file, variable, i + 1, row.fault()));
    }
  }
  builder.add_repairs(check.repairs());
  return std::move(builder).finish();
}

/// Fills a row of Victoria Park's table; a fault if an id is 2^53 or more, or W is singular.
template <int Size>
Fault put_row(double kind, std::uint64_t base, std::uint64_t target, const Vector<Size>& measured, const Matrix<Size>& W,
              Eigen::MatrixXd::RowXpr row) {
  if (std::max(base, target) >= static_cast<std::uint64_t>(kDoubleIdEnd)) return "has an id of 2^53 or more";
  Matrix<Size> P;
  if (auto fault = covariance_of(W, P)) return fault;
  row.head<3>() << kind, static_cast<double>(base), static_cast<double>(target);
  row.segment<Size>(3) = measured.transpose();
  Eigen::Index col = 3 + Size;
  each_of_upper_triangle(P, [&](double entry) { row[col++] = entry; });
  return std::nullopt;
}

}  // namespace

Expected<AnyLog> read_mat_log(std::string_view bytes, const std::string& file, const ReadOptions& options) {
  const auto variables = read_mat(bytes, file, {kVictoriaPark, kDlr});
  if (!variables) return tl::unexpected(variables.error());
  if (const auto found = variables->find(kVictoriaPark); found != variables->end()) {
    return log_of(file, kVictoriaPark, found->second, 12, options, add_victoria_park_row);
  }
  if (const auto found = variables->find(kDlr); found != variables->end()) {
    std::uint64_t step = 0;
    return log_of(file, kDlr, found->second, 10, options,
                  [&](TableRow& row, LogBuilder<2>& builder) { add_dlr_row(row, builder, step); });
  }
  if (const auto map = read_mat(bytes, file, {kPosesOfMap}); map && map->contains(kPosesOfMap)) {
    return bad_input_of(file,
                        "is a map for MATLAB and Octave, which is only written; as .g2o, .tum or .csv maps are read, too");
  }
  return bad_input(fmt::format("{}: holds neither the variable {} nor {}", file, kVictoriaPark, kDlr));
}

Expected<void> write_mat_log(const Log<2>& log, const std::filesystem::path& path) {
  const auto numbering = number_for_g2o(log.poses, {});
  if (!numbering) return tl::unexpected(numbering.error());
  const auto pose = [&](PoseIndex index) { return (*numbering)(log.poses[index]); };
  Eigen::MatrixXd table = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(log.edges().size() + log.observations().size()), 12);
  Eigen::Index row = 0;
  const auto cannot = [&](const std::string& what, const std::string& fault) {
    return tl::unexpected(
        Error{ErrorKind::kUsage, fmt::format("{}: {} {}, which a MAT file cannot say", log.source, what, fault)});
  };
  for (const auto& [base, target, measured, W, loss, lever] : log.edges()) {
    const Vector<3> numbers(measured.translation.x(), measured.translation.y(), measured.rotation.angle());
    const auto fault = put_row<3>(kOdometry, pose(base), pose(target), numbers, W, table.row(row++));
    if (fault) return cannot(name_of(log.poses[base], log.poses[target]), *fault);
  }
  for (const auto& [base, target, measured, W, loss] : log.observations()) {
    const std::uint64_t feature = log.features[target].key;
    const auto fault = put_row<2>(kObservation, pose(base), feature, measured, W, table.row(row++));
    if (fault) return cannot(name_of(log.poses[base], log.features[target]), *fault);
  }
  return mat_bytes({{kVictoriaPark, table}}, path.string()).and_then([&](const std::string& bytes) {
    return write_file(path, bytes);
  });
}

}  // namespace mapjoin
