// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Maps with everything that a picture or a page shows, in one frame; the layers of a picture of them, and a page.

#include <apps/picture/links.hpp>
#include <apps/picture/picture.hpp>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin::apps {

/// A local map within a map: its fit, with its base and end poses, and the features that it saw.
struct PlottedLocalMap {
  MapFit fit;
  std::vector<FeatureIndex> features;
};

/// The join of the first of several local maps: its poses, and the estimates of these and of its features.
template <int Dim>
struct JoinStop {
  std::size_t maps = 0;
  double chi2 = 0.0;
  Table<PoseIndex, PoseIndex> poses;
  Values<Dim> state;  ///< Poses by their place in `poses`; features in no order.
};

template <int Dim>
struct PlottedMap {
  std::string name;  ///< Name in a legend.
  GlobalMap<Dim> map;
  std::vector<Session> sessions;         ///< Runs of poses that a line goes through.
  Table<PoseIndex, Pose<Dim>> odometry;  ///< Poses composed from odometry alone; empty if unknown.
  /// Closures, then observations (if the map is more than odometry), each in the order of the log; then rejected ones.
  std::vector<Link> links;
  std::vector<PlottedLocalMap> local_maps;  ///< Local maps in their order; empty if unknown.
  std::vector<JoinStop<Dim>> stops;         ///< Stops of joining map after map; empty if not recorded.
  bool is_odometry = false;  ///< True if `map` is composed from odometry and first observations, for want of more.
};

using AnyPlottedMap = std::variant<PlottedMap<2>, PlottedMap<3>>;

/// The poses composed from odometry alone, each session from its first pose in `poses`.
template <int Dim>
Table<PoseIndex, Pose<Dim>> dead_reckoning(const Log<Dim>& log, Table<PoseIndex, Pose<Dim>> poses);

/// A log by the values that its file gives to poses and features; otherwise by odometry and first observations.
template <int Dim>
PlottedMap<Dim> plotted(const Log<Dim>& log);
/// The map joined from a log or a set of local maps.
template <int Dim>
PlottedMap<Dim> plotted(const RunResult<Dim>& result, const Log<Dim>& log);
template <int Dim>
PlottedMap<Dim> plotted(const RunResult<Dim>& result, const SubmapSet<Dim>& set);

/// Local maps of a log with the features that were seen from their poses.
template <int Dim>
std::vector<PlottedLocalMap> plotted_local_maps(const std::vector<MapFit>& fits, const Log<Dim>& log);

template <int Dim>
struct Scene {
  std::vector<PlottedMap<Dim>> maps;  ///< At least one.
  std::optional<Truth<Dim>> truth;    ///< Truth of the poses and features of the first map.
};

using AnyScene = std::variant<Scene<2>, Scene<3>>;

/// The rigid motion that best takes `plotted`, or the truth, onto the first map, by the positions that both have. Poses of two
/// maps are the same if their names are or, if one is a trajectory, which has times and only counts its poses, and the other
/// has times, too, if their times are: the clocks of two maps may differ. An error, in a clause, if the positions do not
/// determine a motion, and as for by_time().
template <int Dim>
Expected<Pose<Dim>> alignment(const PlottedMap<Dim>& plotted, const PlottedMap<Dim>& onto);
template <int Dim>
Expected<Pose<Dim>> alignment(const Truth<Dim>& truth, const GlobalMap<Dim>& first);

/// Moves a map, or the truth, by the rigid motion `frame`.
template <int Dim>
void move(const Pose<Dim>& frame, PlottedMap<Dim>& plotted);
template <int Dim>
void move(const Pose<Dim>& frame, Truth<Dim>& truth);

/// The sessions that are drawn in one colour.
struct Trajectory {
  std::string name;  ///< Name in a legend.
  std::string colour;
  std::vector<Session> sessions;
};

/// The trajectories: each session or, with several robots, each robot in a colour of its own; if there are very many, some
/// share one.
template <int Dim>
std::vector<Trajectory> trajectories_of(const PlottedMap<Dim>& plotted);

/// The cap on ellipses of three standard deviations: none is drawn larger than the map.
struct EllipseCap {
  double half_axis = 0.0;    ///< Longest half axis that is drawn (m).
  std::size_t poses = 0;     ///< Number of poses with larger ellipses.
  std::size_t features = 0;  ///< Number of features with larger ellipses.

  std::string in_words() const;  ///< A sentence on larger ellipses; empty if there are none.
};

/// The name of ellipses in a legend.
std::string name_of_ellipses(const std::string& things, std::size_t capped);

template <int Dim>
EllipseCap ellipse_cap(const GlobalMap<Dim>& map);

/// The layers of a picture of one map or several, all in one frame. A single map has all that is known of it: sessions or, if
/// it has only one, local maps in colours of their own, with their ends; closures and observations by their residuals;
/// features; ellipses. Several maps have one colour each. `truth`, of the first map's poses and features, may be null.
template <int Dim>
std::vector<Layer> map_layers(const std::vector<PlottedMap<Dim>>& maps, const Truth<Dim>* truth);

/// A self-contained page to look around in a scene: three.js, the scripts of viewer/, and the scene as data.
template <int Dim>
std::string viewer_page(const Scene<Dim>& scene, const std::string& title);

}  // namespace mapjoin::apps
