// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/io/files/csv_text.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/formats/pose_tables.hpp>
#include <mapjoin/io/g2o/numbering.hpp>
#include <mapjoin/io/local_maps/local_map_file.hpp>
#include <mapjoin/io/run_folder.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <system_error>
#include <utility>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;

/// The poses and features in the tables of a run.
template <int Dim>
Expected<GlobalMap<Dim>> read_tables(const fs::path& poses, const fs::path& features) {
  const auto read_poses = [&](const FileBytes& bytes) { return read_pose_table<Dim>(bytes.view(), poses.string()); };
  return FileBytes::read(poses).and_then(read_poses).and_then([&](GlobalMap<Dim> told) {
    const auto take_feature = [&](const std::vector<std::string>&, TextScanner& row) {
      told.feature_ids.push_back({row.key()});
      told.features.push_back(row.vector<Dim>());
    };
    return each_row(features, take_feature).map([&] { return std::move(told); });
  });
}

/// True if the log already has these names; those of features do not count if it has none.
template <int Dim>
bool has_names(const GlobalMap<Dim>& told, const Log<Dim>& log) {
  const auto has_all = [](const auto& names, const auto& index_of) {
    return std::ranges::all_of(names, [&](const auto& id) { return index_of(id).has_value(); });
  };
  return has_all(told.pose_ids, IndexOf(log.poses)) &&
         (log.features.empty() || has_all(told.feature_ids, IndexOf(log.features)));
}

PoseId numbered(const G2oNumbering& numbering, const PoseId& id) {
  return {0, numbering(id)};
}
FeatureId numbered(const G2oNumbering& numbering, const FeatureId& id) {
  return {numbering(id)};
}

/// Renames poses or features, which have the numbers that g2o gives to `told`, or its names if there is no numbering; false
/// unless each is told once, at its place.
template <typename Index, typename Id, typename Value, typename At>
bool rename(const Table<Index, Id>& told, const Table<Index, Value>& told_values, const G2oNumbering* numbering,
            const Table<Index, Value>& values, const At& position, Table<Index, Id>& names) {
  if (told.size() != names.size() || values.size() != names.size()) return false;
  const IndexOf index_of(names);
  for (const Index k : indices(told)) {
    const auto index = index_of(numbering ? numbered(*numbering, told[k]) : told[k]);
    if (!index || position(values[*index]) != position(told_values[k])) return false;
    names[*index] = told[k];
  }
  return true;
}

tl::unexpected<Error> not_alone(const fs::path& table, const fs::path& missing) {
  return bad_input(fmt::format("{}: is missing beside {}; both tell the names of {}, and without both it is read as it is",
                               missing.string(), table.filename().string(), kMapOfRun));
}

template <int Dim>
Expected<AnyLog> with_names_of_run(const fs::path& folder, Log<Dim> log) {
  const fs::path poses = folder / kPosesOfRun;
  const fs::path features = folder / kFeaturesOfRun;
  std::error_code ignored;
  const bool has_poses = fs::is_regular_file(poses, ignored);
  const bool has_features = fs::is_regular_file(features, ignored);
  if (!has_poses && !has_features) return AnyLog(std::move(log));
  if (!has_poses) return not_alone(features, poses);
  if (!has_features) return not_alone(poses, features);
  const auto told = read_tables<Dim>(poses, features);
  if (!told) return tl::unexpected(told.error());
  return with_names(*told, std::move(log), poses).map([&](Log<Dim>&& named) {
    named.stamps_ns = told->stamps_ns;
    return AnyLog(std::move(named));
  });
}

}  // namespace

tl::unexpected<Error> not_of_map_beside(const fs::path& file) {
  return bad_input(file.string() + ": is not of the map beside it; remove it, or make both in one run");
}

bool is_run_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path / kMapOfRun, ignored) && !has_local_maps(path);
}

template <int Dim>
Expected<Log<Dim>> with_names(const GlobalMap<Dim>& told, Log<Dim> log, const fs::path& file) {
  const auto numbering = number_for_g2o(told.pose_ids, told.feature_ids);
  if (!numbering) return not_of_map_beside(file);
  const G2oNumbering* of_g2o = has_names(told, log) ? nullptr : &*numbering;
  const auto of_pose = [](const Pose<Dim>& pose) { return pose.translation; };
  const auto of_feature = [](const Point<Dim>& feature) { return feature; };
  const bool are_of_map =
      rename(told.pose_ids, told.poses, of_g2o, log.initial.poses, of_pose, log.poses) &&
      (log.features.empty() || rename(told.feature_ids, told.features, of_g2o, log.initial.features, of_feature, log.features));
  if (!are_of_map) return not_of_map_beside(file);
  LogBuilder<Dim> builder(log.source, without_repairs(log.conventions), Numbers::kChecked);
  builder.append(log);
  return std::move(builder).finish(told.pose_ids).map([&](Log<Dim>&& named) {
    named.foreign = std::move(log.foreign);
    return std::move(named);
  });
}

Expected<AnyLog> read_run_folder(const fs::path& folder, const ReadOptions& options) {
  const fs::path map = folder / kMapOfRun;
  return FileBytes::read(map)
      .and_then([&](const FileBytes& bytes) { return read_log(bytes.view(), map.string(), options); })
      .and_then([&](AnyLog any) {
        return std::visit([&](auto&& log) { return with_names_of_run(folder, std::move(log)); }, std::move(any));
      });
}

template Expected<Log<2>> with_names(const GlobalMap<2>&, Log<2>, const fs::path&);
template Expected<Log<3>> with_names(const GlobalMap<3>&, Log<3>, const fs::path&);

}  // namespace mapjoin
