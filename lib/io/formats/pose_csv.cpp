// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <mapjoin/io/files/csv_text.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/formats/pose_tables.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <set>
#include <string>
#include <vector>

namespace mapjoin {
namespace {

/// The columns of a pose, in their order.
template <int Dim>
std::vector<std::string> pose_columns() {
  if constexpr (Dim == 2) {
    return {"x", "y", "phi"};
  } else {
    return {"x", "y", "z", "qx", "qy", "qz", "qw"};
  }
}

template <int Dim>
bool has_poses(const std::vector<std::string>& columns) {
  const auto pose = pose_columns<Dim>();
  return has_column(columns, "pose") && std::search(columns.begin(), columns.end(), pose.begin(), pose.end()) != columns.end();
}

/// Reads a line, which must be the first one of its pose, unlike those `known`; at the column x it reads the whole pose, whose
/// columns stand side by side.
template <int Dim>
void read_row(const std::vector<std::string>& columns, TextScanner& text, GlobalMap<Dim>& table, std::set<PoseId>& known) {
  PoseId id;
  for (auto column = columns.begin(); column != columns.end(); ++column) {
    if (*column == "session") {
      id.session = read_session(text);
    } else if (*column == "pose") {
      id.key = text.key();
    } else if (*column == "x") {
      table.poses.push_back(read_g2o_pose<Dim>(text));
      column += std::ssize(pose_columns<Dim>()) - 1;
    } else if (*column == "stamp_ns") {
      table.stamps_ns.push_back(text.integer());
    } else {
      text.word();
    }
  }
  table.pose_ids.push_back(id);
  known.insert(known.end(), id);
  if (known.size() < table.pose_ids.size()) text.reject(to_string(id) + " has a line before this one");
}

/// The log of the poses, in the order of the table.
template <int Dim>
Expected<AnyLog> log_of_poses(const GlobalMap<Dim>& table, const std::string& file) {
  LogBuilder<Dim> builder(file);
  for (const PoseIndex p : indices(table.poses)) builder.add_pose(table.pose_ids[p], table.poses[p]);
  for (const PoseIndex p : indices(table.stamps_ns)) builder.add_stamp(table.pose_ids[p], table.stamps_ns[p]);
  return std::move(builder).finish(table.pose_ids);
}

}  // namespace

bool is_pose_csv(std::string_view bytes) {
  const std::vector<std::string> columns = csv_columns(bytes);
  return has_column(columns, "pose") && has_column(columns, "x") && has_column(columns, "y");
}

template <int Dim>
Expected<GlobalMap<Dim>> read_pose_table(std::string_view bytes, const std::string& file) {
  const std::vector<std::string> columns = csv_columns(bytes);
  const std::string place = header_place(bytes, file);
  if (auto named = check_named_once(columns, {"session", "pose", "x", "stamp_ns"}, place); !named)
    return tl::unexpected(named.error());
  if (!has_poses<Dim>(columns)) {
    return bad_input(
        fmt::format("{}: does not name the columns pose and, side by side, {}", place, fmt::join(pose_columns<Dim>(), ",")));
  }
  const std::string words = cells_as_words(bytes);
  TextScanner text(file, words);
  text.next_line();
  GlobalMap<Dim> table;
  std::set<PoseId> known;
  return text.each_line([&] { read_row(columns, text, table, known); }).map([&] { return std::move(table); });
}

Expected<AnyLog> read_pose_csv(std::string_view bytes, const std::string& file, const ReadOptions&) {
  const auto read_as = [&]<int Dim>(const GlobalMap<Dim>&) {
    return read_pose_table<Dim>(bytes, file).and_then([&](const GlobalMap<Dim>& table) { return log_of_poses(table, file); });
  };
  const std::vector<std::string> columns = csv_columns(bytes);
  const bool is_in_space = !has_poses<2>(columns) && has_column(columns, "z");
  return is_in_space ? read_as(GlobalMap<3>()) : read_as(GlobalMap<2>());
}

template Expected<GlobalMap<2>> read_pose_table<2>(std::string_view, const std::string&);
template Expected<GlobalMap<3>> read_pose_table<3>(std::string_view, const std::string&);

}  // namespace mapjoin
