// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Maps with all that a picture or a page of them shows, in one frame; the layers of a picture of them, and a page.

#include <apps/picture/links.hpp>
#include <apps/picture/picture.hpp>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin::apps {

/// A local map within a map: how it fits, with the poses from its base to its end, and the features that it saw.
struct PlottedLocalMap {
  MapFit fit;
  std::vector<FeatureIndex> features;
};

/// The join of the first maps of several: the poses that it held, and where they and its features were.
template <int Dim>
struct JoinStop {
  std::size_t maps = 0;
  double chi2 = 0.0;
  Table<PoseIndex, PoseIndex> poses;
  Values<Dim> state;  ///< Poses by place in `poses`; the features in no order.
};

template <int Dim>
struct PlottedMap {
  std::string name;  ///< In a legend.
  GlobalMap<Dim> map;
  std::vector<Session> sessions;         ///< Poses that a line goes through.
  Table<PoseIndex, Pose<Dim>> odometry;  ///< Composed from odometry alone; empty where that is not known.
  /// Closures, then observations, each in the order of the log, of odometry alone closures only; then those that were rejected.
  std::vector<Link> links;
  std::vector<PlottedLocalMap> local_maps;  ///< In their order; empty where they are not known.
  std::vector<JoinStop<Dim>> stops;         ///< On the way of joining map after map; empty where it was not watched.
  bool is_odometry = false;                 ///< `map` is composed from odometry and first observations, for want of more.
};

using AnyPlottedMap = std::variant<PlottedMap<2>, PlottedMap<3>>;

/// The poses composed from odometry alone, each session from where `poses` has its first one.
template <int Dim>
Table<PoseIndex, Pose<Dim>> dead_reckoning(const Log<Dim>& log, Table<PoseIndex, Pose<Dim>> poses);

/// A log by the values that its file gives to poses and features, else by odometry and first observations.
template <int Dim>
PlottedMap<Dim> plotted(const Log<Dim>& log);
/// What came of a log, or of a set of local maps.
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
  std::optional<Truth<Dim>> truth;    ///< Over the poses and features of the first map.
};

using AnyScene = std::variant<Scene<2>, Scene<3>>;

/// The rigid motion that best takes `map`, and the truth of a map, onto `first`, by the places of what both know; nothing where
/// that does not determine one.
template <int Dim>
std::optional<Pose<Dim>> alignment(const GlobalMap<Dim>& map, const GlobalMap<Dim>& first);
template <int Dim>
std::optional<Pose<Dim>> alignment(const Truth<Dim>& truth, const GlobalMap<Dim>& first);

/// The same map seen from another frame: moved by `frame`.
template <int Dim>
void move(const Pose<Dim>& frame, PlottedMap<Dim>& plotted);
template <int Dim>
void move(const Pose<Dim>& frame, Truth<Dim>& truth);

/// What has one colour of a trajectory.
struct Trajectory {
  std::string name;  ///< In a legend.
  std::string colour;
  std::vector<Session> sessions;
};

/// Each session, or where poses are of several robots each of these, in a colour of its own; of very many some share one.
template <int Dim>
std::vector<Trajectory> trajectories_of(const PlottedMap<Dim>& plotted);

/// Ellipses of three standard deviations, of which none is drawn larger than the map.
struct EllipseCap {
  double half_axis = 0.0;    ///< The longest that is drawn (m).
  std::size_t poses = 0;     ///< Those whose ellipses are larger,
  std::size_t features = 0;  ///< and features.

  std::string in_words() const;  ///< What to say of them; empty where there are none.
};

/// In a legend.
std::string name_of_ellipses(const std::string& things, std::size_t capped);

template <int Dim>
EllipseCap ellipse_cap(const GlobalMap<Dim>& map);

/// A single map with all that is known of it: sessions or, of a single one, local maps in colours of their own, where they end,
/// closures and observations by their residuals, features, ellipses. Several maps each in one colour. `truth`, over the first
/// map's poses and features, may be null. At least one map, all in one frame.
template <int Dim>
std::vector<Layer> map_layers(const std::vector<PlottedMap<Dim>>& maps, const Truth<Dim>* truth);

/// One self-contained page to look around in a scene: three.js and the scripts of viewer/, and the scene as data.
template <int Dim>
std::string viewer_page(const Scene<Dim>& scene, const std::string& title);

}  // namespace mapjoin::apps
