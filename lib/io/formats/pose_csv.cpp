// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/io/files/csv_text.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/formats/pose_tables.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <string>
#include <vector>

namespace mapjoin {
namespace {

/// One line of the table.
template <int Dim>
struct PoseRow {
  PoseId id;
  Pose<Dim> pose;
  std::int64_t stamp_ns = 0;
};

/// Reads a line; at the column x it reads the whole pose.
template <int Dim>
PoseRow<Dim> read_row(const std::vector<std::string>& columns, TextScanner& text) {
  static const std::vector<std::string> kBehindX = {"y", "z", "phi", "qx", "qy", "qz", "qw"};
  PoseRow<Dim> row;
  for (const std::string& column : columns) {
    if (column == "session") {
      row.id.session = read_session(text);
    } else if (column == "pose") {
      row.id.key = text.key();
    } else if (column == "x") {
      row.pose = read_g2o_pose<Dim>(text);
    } else if (column == "stamp_ns") {
      row.stamp_ns = text.integer();
    } else if (!has_column(kBehindX, column)) {
      text.word();
    }
  }
  return row;
}

template <int Dim>
Expected<AnyLog> read_rows(const std::vector<std::string>& columns, TextScanner text) {
  LogBuilder<Dim> builder(text.source());
  text.next_line();
  const auto read_line = [&] {
    const PoseRow<Dim> row = read_row<Dim>(columns, text);
    builder.add_pose(row.id, row.pose);
    if (has_column(columns, "stamp_ns")) builder.add_stamp(row.id, row.stamp_ns);
  };
  return text.each_line(read_line).and_then([&]() -> Expected<AnyLog> { return std::move(builder).finish(); });
}

}  // namespace

bool is_pose_csv(std::string_view bytes) {
  const std::vector<std::string> columns = csv_columns(bytes);
  return has_column(columns, "pose") && has_column(columns, "x") && has_column(columns, "y");
}

Expected<AnyLog> read_pose_csv(std::string_view bytes, const std::string& file, const ReadOptions&) {
  const std::vector<std::string> columns = csv_columns(bytes);
  const auto follow = [&](const std::vector<std::string>& names) {
    return std::search(columns.begin(), columns.end(), names.begin(), names.end()) != columns.end();
  };
  if (auto named = check_named_once(columns, {"session", "pose", "x", "stamp_ns"}, file); !named)
    return tl::unexpected(named.error());
  const std::string blanks = with_blanks(bytes);
  const TextScanner text(file, blanks);
  if (has_column(columns, "pose") && follow({"x", "y", "phi"})) return read_rows<2>(columns, text);
  if (has_column(columns, "pose") && follow({"x", "y", "z", "qx", "qy", "qz", "qw"})) return read_rows<3>(columns, text);
  return bad_input(file + ": its first line does not name the columns pose and x,y,phi, or x,y,z,qx,qy,qz,qw");
}

}  // namespace mapjoin
