// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>
#include <mapjoin/io/open.hpp>
#include <mapjoin/io/store/records.hpp>
#include <mapjoin/io/store/store.hpp>
#include <stdexcept>
#include <tests/fuzz/promises.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::fuzz {
namespace {

template <typename Record>
void put(const std::vector<Record>& records, std::string& bits) {
  bits += std::to_string(records.size()) + ' ' + store::encode_all(records);
}

template <int Dim>
std::string bits(const Log<Dim>& log) {
  std::string bits;
  put(log.poses, bits);
  put(log.features, bits);
  for (const Session& session : log.sessions) bits += std::to_string(session.end.value) + ' ';
  put(log.graph.pose_factors, bits);
  put(log.graph.feature_factors, bits);
  put(log.graph.fixed, bits);
  put(log.stamps_ns, bits);
  put(log.initial.poses, bits);
  put(log.initial.features, bits);
  return bits;
}

template <int Dim>
std::string bits(const SubmapSet<Dim>& set) {
  std::string bits;
  put(set.poses, bits);
  put(set.features, bits);
  put(set.segments, bits);
  for (const LocalMap<Dim>& map : set.graph.submaps) {
    put(map.poses, bits);
    put(map.features, bits);
    put(map.pose_estimates, bits);
    put(map.feature_estimates, bits);
    bits += store::encode_upper(map.information);
  }
  return bits;
}

void expect(const Expected<void>& checked) {
  promise(checked.has_value(), checked ? "" : checked.error().message);
}

/// Checks that indices and numbers are right, poses are named once, features ascend, sessions hold every pose, observations are
/// in the order of their poses, and initial values and stamps are there for all or for none.
template <int Dim>
void check_one(const Log<Dim>& log) {
  SubmapSet<Dim> set;
  set.poses = log.poses;
  set.features = log.features;
  set.graph = log.graph;
  expect(check_content(set));
  auto poses = log.poses;
  std::ranges::sort(poses);
  promise(!poses.empty() && std::ranges::adjacent_find(poses) == poses.end(), "poses are named once");
  promise(std::ranges::adjacent_find(log.features, std::greater_equal()) == log.features.end(), "features ascend");
  PoseIndex next = 0;
  for (const Session& session : log.sessions) {
    promise(session.begin == next && session.end > next, "sessions follow each other");
    next = session.end;
  }
  promise(next == indices(log.poses).last, "sessions hold every pose");
  promise(std::ranges::is_sorted(log.observations(), {}, &FeatureFactor<Dim>::base), "observations are in order");
  const auto are_valid = [](const auto& values, std::size_t names) {
    const bool is_each = std::all_of(values.begin(), values.end(), [](const auto& value) { return is_valid(value); });
    return is_each && (values.empty() || values.size() == names);
  };
  promise(are_valid(log.initial.poses, log.poses.size()) && are_valid(log.initial.features, log.features.size()),
          "initial values are finite, and all or none");
  promise(log.stamps_ns.empty() || log.stamps_ns.size() == log.poses.size(), "every pose has a stamp, or none");
}

}  // namespace

void promise(bool kept, std::string_view what) {
  if (!kept) throw std::logic_error("a promise is broken: " + std::string(what));
}

void check_error(const Error& error, const std::string& file) {
  const auto is_text = [](char c) { return c >= ' ' && c <= '~'; };
  promise(std::all_of(error.message.begin(), error.message.end(), is_text), "a message is a line of text: " + error.message);
  promise(error.message.starts_with(file), "a message names its file: " + error.message);
}

std::string bits_of(const AnyLog& log) {
  return std::visit([](const auto& any) { return bits(any); }, log);
}
std::string bits_of(const AnySubmapSet& set) {
  return std::visit([](const auto& any) { return bits(any); }, set);
}

void check_log(const AnyLog& log) {
  std::visit([](const auto& any) { check_one(any); }, log);
}

void check_maps(const AnySubmapSet& any) {
  const auto check = []<int Dim>(const SubmapSet<Dim>& set) {
    promise(set.segments.size() == set.graph.submaps.size(), "every map has its segment");
    expect(check_content(set));
    for (std::size_t k = 0; k < set.graph.submaps.size(); ++k) {
      const LocalMap<Dim>& map = set.graph.submaps[k];
      const Segment& segment = set.segments[k];
      promise(map.base == segment.begin && (map.poses.empty() ? map.base : map.poses.back()) == segment.end,
              "a map goes from end to end of its segment");
    }
  };
  std::visit(check, any);
}

void check(const Expected<AnyLog>& log, const std::string& file) {
  log ? check_log(*log) : check_error(log.error(), file);
}
void check(const Expected<AnySubmapSet>& set, const std::string& file) {
  set ? check_maps(*set) : check_error(set.error(), file);
}

void check_round_trip(const AnyLog& any, LogFormat format) {
  static const testing::TemporaryFolder folder;
  const auto path = folder.path() / "written";
  const auto write_and_read = [&](const auto& log) {
    const bool has_edges = !log.odometry().empty() || !log.closures().empty();
    if (!has_edges && log.observations().empty() && log.initial.poses.empty()) return;  // Nothing to write.
    if (!has_edges && format == LogFormat::kGtsam) return;  // Read as iSAM's format without an edge.
    if (!write_log(log, format, path)) return;              // The format cannot hold it.
    const auto read = open_log(path);
    promise(read.has_value(), "what was written reads back: " + (read ? "" : read.error().message));
    check_log(*read);
    if (losses(log, format).empty()) promise(bits_of(*read) == bits_of(any), "what is written without loss is the same");
  };
  std::visit(write_and_read, any);
}

}  // namespace mapjoin::fuzz
