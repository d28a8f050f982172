// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <mapjoin/gps/geographic_frame.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/text_line.hpp>
#include <mapjoin/io/formats/map_text.hpp>

namespace mapjoin {
namespace {

template <int Dim>
GeographicPoint place_of(const Point<Dim>& point, const GeographicFrame& frame) {
  Point<3> local = Point<3>::Zero();
  local.head<Dim>() = point;
  return frame.to_geographic(local);
}

/// `[longitude,latitude]`, in space with the height.
template <int Dim>
std::string position(const Point<Dim>& point, const GeographicFrame& frame) {
  const GeographicPoint place = place_of<Dim>(point, frame);
  const std::string flat = fmt::format("{},{}", place.longitude, place.latitude);
  return Dim == 2 ? "[" + flat + "]" : fmt::format("[{},{}]", flat, place.height);
}

std::string object(std::string_view type, const std::string& coordinates, const std::string& properties) {
  return fmt::format(R"({{"type":"Feature","geometry":{{"type":"{}","coordinates":{}}},"properties":{{{}}}}})", type,
                     coordinates, properties);
}

}  // namespace

template <int Dim>
Expected<void> write_geographic_csv(const GlobalMap<Dim>& map, const GeographicFrame& frame,
                                    const std::filesystem::path& path) {
  demand_whole(map);
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  const bool has_sessions = std::ranges::any_of(map.pose_ids, [](const PoseId& id) { return id.session != 0; });
  TextLine line(',');
  if (has_sessions) line.add("session");
  line.add(Dim == 2 ? "pose,latitude,longitude" : "pose,latitude,longitude,height");
  if (!map.stamps_ns.empty()) line.add("stamp_ns");
  line.write_to(*file);
  for (const PoseIndex p : indices(map.poses)) {
    const GeographicPoint place = place_of<Dim>(map.poses[p].translation, frame);
    if (has_sessions) line.add(map.pose_ids[p].session);
    line.add(key_text(map.pose_ids[p].key)).add(place.latitude).add(place.longitude);
    if (Dim == 3) line.add(place.height);
    if (!map.stamps_ns.empty()) line.add(map.stamps_ns[p]);
    line.write_to(*file);
  }
  return file->commit();
}

template <int Dim>
Expected<void> write_geojson(const GlobalMap<Dim>& map, const GeographicFrame& frame, const std::filesystem::path& path) {
  demand_whole(map);
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  file->write("{\"type\":\"FeatureCollection\",\"features\":[\n");
  std::vector<std::string> positions;
  for (const PoseIndex p : indices(map.poses)) {
    const std::uint32_t session = map.pose_ids[p].session;
    positions.push_back(position<Dim>(map.poses[p].translation, frame));
    const bool is_last = p + 1 == indices(map.poses).last;
    if (!is_last && map.pose_ids[p + 1].session == session) continue;
    const std::string name = fmt::format("\"session\":{}", session);
    const std::string line = fmt::format("[{}]", fmt::join(positions, ",\n"));
    file->write(positions.size() > 1 ? object("LineString", line, name) : object("Point", positions.front(), name));
    file->write(is_last && map.features.empty() ? "\n" : ",\n");
    positions.clear();
  }
  for (const FeatureIndex f : indices(map.features)) {
    const std::string name = fmt::format("\"feature\":\"{}\"", key_text(map.feature_ids[f].key));
    file->write(object("Point", position<Dim>(map.features[f], frame), name));
    file->write(f + 1 == indices(map.features).last ? "\n" : ",\n");
  }
  file->write("]}\n");
  return file->commit();
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                             \
  template Expected<void> write_geographic_csv(const GlobalMap<Dim>&, const GeographicFrame&, const std::filesystem::path&); \
  template Expected<void> write_geojson(const GlobalMap<Dim>&, const GeographicFrame&, const std::filesystem::path&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
