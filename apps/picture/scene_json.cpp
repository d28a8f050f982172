// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/picture/markup.hpp>
#include <apps/picture/viewer_page.hpp>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>

namespace mapjoin::apps {
namespace {

using Json = nlohmann::ordered_json;

/// Three numbers per place, in the plane with z = 0, about a centre: 32-bit floats then tell a micrometre at ten metres.
template <int Dim>
class Places {
 public:
  explicit Places(const Point<Dim>& centre) : centre_(centre) {}

  void add(const Point<Dim>& p) {
    for (int i = 0; i < 3; ++i) numbers_.push_back(i < Dim ? static_cast<float>(p[i] - centre_[i]) : 0.0F);
  }
  void add_unknown() { numbers_.insert(numbers_.end(), 3, std::numeric_limits<float>::quiet_NaN()); }
  std::string text() const { return base64(numbers_); }

 private:
  Point<Dim> centre_;
  std::vector<float> numbers_;
};

template <int Dim>
std::string places_of(const std::vector<Pose<Dim>>& poses, const Point<Dim>& centre) {
  Places<Dim> places(centre);
  for (const Pose<Dim>& pose : poses) places.add(pose.translation);
  return places.text();
}
template <int Dim>
std::string places_of(const std::vector<Point<Dim>>& points, const Point<Dim>& centre) {
  Places<Dim> places(centre);
  for (const Point<Dim>& point : points) places.add(point);
  return places.text();
}

template <typename Id>
std::string keys_of(const std::vector<Id>& ids) {
  std::vector<std::uint64_t> keys;
  for (const Id& id : ids) keys.push_back(id.key);
  return base64(keys);
}

/// Per pose, or nothing where all are of session 0.
std::string robots_of(const std::vector<PoseId>& ids) {
  std::vector<std::uint32_t> robots;
  for (const PoseId& id : ids) robots.push_back(id.session);
  const bool is_one = std::all_of(robots.begin(), robots.end(), [](std::uint32_t robot) { return robot == 0; });
  return is_one ? "" : base64(robots);
}

/// Headings in the plane; in space none are shown.
std::string headings_of(const std::vector<Pose<2>>& poses) {
  std::vector<float> headings;
  for (const Pose<2>& pose : poses) headings.push_back(static_cast<float>(wrap_angle(pose.rotation.angle())));
  return base64(headings);
}
std::string headings_of(const std::vector<Pose<3>>&) {
  return "";
}

/// Upper triangles, row by row.
template <typename Covariance>
std::string triangles_of(const std::vector<Covariance>& covariances) {
  std::vector<float> entries;
  for (const Covariance& P : covariances) {
    for (int i = 0; i < P.rows(); ++i) {
      for (int j = i; j < P.cols(); ++j) entries.push_back(static_cast<float>(P(i, j)));
    }
  }
  return base64(entries);
}

std::uint32_t unsigned_of(Index index) {
  return static_cast<std::uint32_t>(index);
}

std::string indices_of(const std::vector<Index>& indices) {
  std::vector<std::uint32_t> numbers;
  for (const Index index : indices) numbers.push_back(unsigned_of(index));
  return base64(numbers);
}

Json local_maps_of(const std::vector<PlottedLocalMap>& maps) {
  std::vector<std::uint32_t> bases, ends, rows, features;
  std::vector<std::uint32_t> offsets = {0};
  std::vector<double> chi2, probabilities;
  for (const PlottedLocalMap& map : maps) {
    bases.push_back(unsigned_of(map.fit.base));
    ends.push_back(unsigned_of(map.fit.end));
    rows.push_back(static_cast<std::uint32_t>(map.fit.rows));
    chi2.push_back(map.fit.chi2);
    probabilities.push_back(map.fit.probability());
    for (const Index feature : map.features) features.push_back(unsigned_of(feature));
    offsets.push_back(static_cast<std::uint32_t>(features.size()));
  }
  return {{"count", maps.size()},       {"base", base64(bases)},       {"end", base64(ends)},
          {"chi2", base64(chi2)},       {"rows", base64(rows)},        {"probability", base64(probabilities)},
          {"offsets", base64(offsets)}, {"features", base64(features)}};
}

template <int Dim>
Json stops_of(const std::vector<JoinStop<Dim>>& stops, const Point<Dim>& centre) {
  Json list = Json::array();
  for (const JoinStop<Dim>& stop : stops) {
    list.push_back({{"maps", stop.maps},
                    {"chi2", stop.chi2},
                    {"poses", indices_of(stop.poses)},
                    {"posePlaces", places_of(stop.state.poses, centre)},
                    {"featurePlaces", places_of(stop.state.features, centre)}});
  }
  return list;
}

template <int Dim>
Json map_of(const PlottedMap<Dim>& plotted, const Point<Dim>& centre) {
  const GlobalMap<Dim>& map = plotted.map;
  std::vector<std::uint32_t> sessions, closures;
  for (const Session& session : plotted.sessions) {
    sessions.insert(sessions.end(), {unsigned_of(session.begin), unsigned_of(session.end)});
  }
  for (const auto& [base, target] : plotted.closures) {
    closures.insert(closures.end(), {unsigned_of(base), unsigned_of(target)});
  }
  return {{"name", plotted.name},
          {"isOdometry", plotted.is_odometry},
          {"poses", places_of(map.poses, centre)},
          {"headings", headings_of(map.poses)},
          {"poseKeys", keys_of(map.pose_ids)},
          {"robots", robots_of(map.pose_ids)},
          {"sessions", base64(sessions)},
          {"poseCovariances", triangles_of(map.pose_covariances)},
          {"features", places_of(map.features, centre)},
          {"featureKeys", keys_of(map.feature_ids)},
          {"featureCovariances", triangles_of(map.feature_covariances)},
          {"odometry", places_of(plotted.odometry, centre)},
          {"closures", base64(closures)},
          {"localMaps", local_maps_of(plotted.local_maps)},
          {"stops", stops_of(plotted.stops, centre)}};
}

template <int Dim>
Json truth_of(const std::optional<Truth<Dim>>& truth, const Point<Dim>& centre) {
  if (!truth) return nullptr;
  Places<Dim> poses(centre);
  Places<Dim> features(centre);
  for (const auto& pose : truth->poses) pose ? poses.add(pose->translation) : poses.add_unknown();
  for (const auto& feature : truth->features) feature ? features.add(*feature) : features.add_unknown();
  return {{"poses", poses.text()}, {"features", features.text()}};
}

/// Of the box around all poses.
template <int Dim>
Point<Dim> middle_of(const std::vector<Pose<Dim>>& poses) {
  if (poses.empty()) return Point<Dim>::Zero();
  Point<Dim> low = poses.front().translation;
  Point<Dim> high = low;
  for (const Pose<Dim>& pose : poses) {
    low = low.cwiseMin(pose.translation);
    high = high.cwiseMax(pose.translation);
  }
  return 0.5 * (low + high);
}

}  // namespace

template <int Dim>
std::string scene_json(const Scene<Dim>& scene, const std::string& title) {
  const Point<Dim> centre = middle_of(scene.maps.front().map.poses);
  Json maps = Json::array();
  for (const auto& plotted : scene.maps) maps.push_back(map_of(plotted, centre));
  const Json json = {{"title", title},
                     {"dimension", Dim},
                     {"centre", std::vector<double>(centre.begin(), centre.end())},
                     {"maps", std::move(maps)},
                     {"truth", truth_of(scene.truth, centre)}};
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) text.replace(at, 1, "\\u003c");
  return text;
}

template std::string scene_json(const Scene<2>&, const std::string&);
template std::string scene_json(const Scene<3>&, const std::string&);

}  // namespace mapjoin::apps
