// SPDX-License-Identifier: BSD-3-Clause
#include "reference_start.hpp"

#include <fmt/format.h>

#include <fstream>
#include <mapjoin/io/open.hpp>
#include <sstream>
#include <string_view>
#include <tests/support/starts.hpp>

namespace mapjoin::bench {
namespace {

template <int Dim>
Pose<Dim> from_tum(const Point<3>& t, const Eigen::Quaterniond& q) {
  if constexpr (Dim == 2) {
    return {t.head<2>(), Rotation<2>(2.0 * std::atan2(q.z(), q.w()))};
  } else {
    return {t, Rotation<3>(q.normalized())};
  }
}

template <int Dim>
Expected<Table<PoseIndex, Pose<Dim>>> read_tum(const std::string& path, std::size_t count) {
  std::ifstream file(path);
  Table<PoseIndex, Pose<Dim>> poses;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    double stamp = 0.0;
    Point<3> t;
    Eigen::Quaterniond q;
    std::istringstream fields(line);
    if (!(fields >> stamp >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w())) {
      return bad_input(fmt::format("{}: '{}' is no line of a TUM trajectory", path, line));
    }
    poses.push_back(from_tum<Dim>(t, q));
  }
  if (poses.size() != count) return bad_input(fmt::format("{}: has {} poses where {} are needed", path, poses.size(), count));
  return poses;
}

template <int Dim>
Expected<Values<Dim>> read_g2o_vertices(const std::string& path, std::size_t poses, std::size_t features) {
  const auto opened = open_log(path);
  if (!opened) return tl::unexpected(opened.error());
  const auto* log = std::get_if<Log<Dim>>(&*opened);
  if (!log || log->initial.poses.size() != poses || log->initial.features.size() != features) {
    return bad_input(fmt::format("{}: needs vertices for {} poses and {} features in {}D", path, poses, features, Dim));
  }
  return Values<Dim>{log->initial.poses, log->initial.features};
}

/// The start in a file, `tum:FILE` or `g2o:FILE`.
template <int Dim, typename Data>
Expected<Values<Dim>> start_from_file(const Data& data, const std::string& name) {
  const std::string_view kind = std::string_view(name).substr(0, 4);
  const std::string path = name.substr(std::min<std::size_t>(4, name.size()));
  if (kind == "g2o:") return read_g2o_vertices<Dim>(path, data.poses.size(), data.features.size());
  if (kind != "tum:") return bad_input(fmt::format("'{}' is no start for this file", name));
  return read_tum<Dim>(path, data.poses.size()).map([&](auto&& poses) {
    return testing::with_first_observations(data, std::forward<decltype(poses)>(poses));
  });
}

}  // namespace

template <int Dim>
Expected<Values<Dim>> start_of(const Log<Dim>& log, const std::string& name) {
  if (name == "odometry") return testing::odometry_start(log);
  if (name == "tree") return testing::spanning_tree_start(log);
  if (name == "values") {
    if (const auto start = testing::file_start(log)) return *start;
    return bad_input(log.source + ": has no initial values");
  }
  return start_from_file<Dim>(log, name);
}

template <int Dim>
Expected<Values<Dim>> start_of(const SubmapSet<Dim>& set, const std::string& name) {
  if (name == "odometry" || name == "tree") return testing::composed_start(set);
  return start_from_file<Dim>(set, name);
}

template Expected<Values<2>> start_of(const Log<2>&, const std::string&);
template Expected<Values<3>> start_of(const Log<3>&, const std::string&);
template Expected<Values<2>> start_of(const SubmapSet<2>&, const std::string&);
template Expected<Values<3>> start_of(const SubmapSet<3>&, const std::string&);

}  // namespace mapjoin::bench
