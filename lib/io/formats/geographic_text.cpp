// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/gps/geographic_frame.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/text_line.hpp>
#include <mapjoin/io/formats/map_text.hpp>

namespace mapjoin {
namespace {

using Track = std::vector<GeographicPoint>;

/// The GeoJSON position `[longitude,latitude]`, in space with the height.
template <int Dim>
std::string position(const GeographicPoint& place) {
  const std::string flat = fmt::format("{},{}", place.longitude, place.latitude);
  return Dim == 2 ? "[" + flat + "]" : fmt::format("[{},{}]", flat, place.height);
}

template <int Dim>
std::string positions_of(const Track& line) {
  std::vector<std::string> all;
  for (const GeographicPoint& place : line) all.push_back(position<Dim>(place));
  return fmt::format("[{}]", fmt::join(all, ",\n"));
}

/// The point where the short way from one place to another crosses the antimeridian, on the side of the first one.
GeographicPoint crossing(const GeographicPoint& from, const GeographicPoint& to) {
  const double before = 180.0 - std::abs(from.longitude);
  const double behind = 180.0 - std::abs(to.longitude);
  const double share = before > 0.0 ? before / (before + behind) : 0.0;
  return {std::lerp(from.latitude, to.latitude, share), std::copysign(180.0, from.longitude),
          std::lerp(from.height, to.height, share)};
}

/// The lines of a trajectory, cut where it crosses the antimeridian (RFC 7946, section 3.1.9).
std::vector<Track> cut_at_antimeridian(const Track& trajectory) {
  std::vector<Track> lines(1);
  for (const GeographicPoint& place : trajectory) {
    Track& line = lines.back();
    if (!line.empty() && std::abs(place.longitude - line.back().longitude) > 180.0) {
      GeographicPoint cut = crossing(line.back(), place);
      line.push_back(cut);
      cut.longitude = -cut.longitude;
      lines.push_back({cut});
    }
    lines.back().push_back(place);
  }
  return lines;
}

std::string object(std::string_view type, const std::string& coordinates, const std::string& properties) {
  return fmt::format(R"({{"type":"Feature","geometry":{{"type":"{}","coordinates":{}}},"properties":{{{}}}}})", type,
                     coordinates, properties);
}

template <int Dim>
std::string trajectory_object(const Track& trajectory, std::uint32_t session) {
  const std::string name = fmt::format("\"session\":{}", session);
  if (trajectory.size() == 1) return object("Point", position<Dim>(trajectory.front()), name);
  std::vector<std::string> lines;
  for (const Track& line : cut_at_antimeridian(trajectory)) lines.push_back(positions_of<Dim>(line));
  if (lines.size() == 1) return object("LineString", lines.front(), name);
  return object("MultiLineString", fmt::format("[{}]", fmt::join(lines, ",\n")), name);
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
    const GeographicPoint place = frame.to_geographic(map.poses[p].translation);
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
  Track trajectory;
  for (const PoseIndex p : indices(map.poses)) {
    const std::uint32_t session = map.pose_ids[p].session;
    trajectory.push_back(frame.to_geographic(map.poses[p].translation));
    const bool is_last = p + 1 == indices(map.poses).last;
    if (!is_last && map.pose_ids[p + 1].session == session) continue;
    file->write(trajectory_object<Dim>(trajectory, session));
    file->write(is_last && map.features.empty() ? "\n" : ",\n");
    trajectory.clear();
  }
  for (const FeatureIndex f : indices(map.features)) {
    const std::string name = fmt::format("\"feature\":\"{}\"", key_text(map.feature_ids[f].key));
    file->write(object("Point", position<Dim>(frame.to_geographic(map.features[f])), name));
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
