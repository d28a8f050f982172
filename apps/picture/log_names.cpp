// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/exit_code.hpp>
#include <apps/picture/log_names.hpp>
#include <apps/picture/picture.hpp>
#include <apps/picture/table_lines.hpp>

namespace mapjoin::apps {
namespace {

namespace fs = std::filesystem;

template <int Dim>
void take_poses(const fs::path& table, GlobalMap<Dim>& told) {
  each_line(table, [&](TextScanner& line, const std::string& header) {
    const std::uint32_t session = header == "session" ? read_session(line) : 0;
    told.pose_ids.push_back({session, line.key()});
    told.poses.push_back({line.vector<Dim>(), {}});
  });
}

template <int Dim>
void take_features(const fs::path& table, GlobalMap<Dim>& told) {
  each_line(table, [&](TextScanner& line, const std::string&) {
    told.feature_ids.push_back({line.key()});
    told.features.push_back(line.vector<Dim>());
  });
}

/// Whether all of a map, and nothing else, is told under these names, each where it is.
template <typename Id, typename Index, typename Value>
bool are_of(const Table<Index, Id>& names, const Table<Index, Value>& told, const Table<Index, Value>& of_map,
            const LogNames& index_of) {
  const auto is_there = [&](Index k) {
    const auto index = index_of(names[k]);
    return index && *place_of(told[k]) == *place_of(of_map[*index]);
  };
  return told.size() == of_map.size() && std::ranges::all_of(indices(told), is_there);
}

}  // namespace

void fail_not_of_map(const fs::path& file) {
  fail(ErrorKind::kBadInput, file.string() + ": is not of the map beside it; remove it, or make both in one run");
}

template <int Dim>
LogNames::LogNames(const fs::path& file, const GlobalMap<Dim>& told, const GlobalMap<Dim>& map)
    : numbering_(number_for_g2o(told.pose_ids, told.feature_ids).value_or(G2oNumbering())),
      poses_(map.pose_ids),
      features_(map.feature_ids) {
  const bool has_features = map.features.empty() || are_of(told.feature_ids, told.features, map.features, *this);
  if (!has_features || !are_of(told.pose_ids, told.poses, map.poses, *this)) fail_not_of_map(file);
}

template <int Dim>
LogNames LogNames::of_run(const fs::path& folder, const GlobalMap<Dim>& map) {
  GlobalMap<Dim> told;
  take_poses(folder / "poses.csv", told);
  take_features(folder / "features.csv", told);
  return LogNames(folder / "poses.csv", told, map);
}

std::optional<PoseIndex> LogNames::operator()(const PoseId& id) const {
  const auto same = poses_(id);
  return same ? same : poses_({0, numbering_(id)});
}

std::optional<FeatureIndex> LogNames::operator()(const FeatureId& id) const {
  return features_({numbering_(id)});
}

#define MAPJOIN_INSTANTIATE(Dim)                                                              \
  template LogNames::LogNames(const fs::path&, const GlobalMap<Dim>&, const GlobalMap<Dim>&); \
  template LogNames LogNames::of_run(const fs::path&, const GlobalMap<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
