// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
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
  put(log.sessions, bits);
  put(log.odometry, bits);
  put(log.closures, bits);
  put(log.observations, bits);
  put(log.pose_priors, bits);
  put(log.feature_priors, bits);
  put(log.fixed, bits);
  put(log.stamps_ns, bits);
  put(log.initial_poses, bits);
  put(log.initial_features, bits);
  return bits;
}

template <int Dim>
std::string bits(const MapSet<Dim>& set) {
  std::string bits;
  put(set.poses, bits);
  put(set.features, bits);
  put(set.stretches, bits);
  for (const LocalMap<Dim>& map : set.maps) {
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
std::string bits_of(const AnyMapSet& set) {
  return std::visit([](const auto& any) { return bits(any); }, set);
}

void check_log(const AnyLog& log) {
  std::visit([](const auto& any) { expect(store::check_log(any, "the log")); }, log);
}

void check_maps(const AnyMapSet& any) {
  const auto check = []<int Dim>(const MapSet<Dim>& set) {
    Log<Dim> names;
    names.poses = set.poses;
    names.features = set.features;
    promise(set.stretches.size() == set.maps.size(), "every map has its stretch");
    expect(store::check_stretches(set.stretches, names, "the maps"));
    for (std::size_t k = 0; k < set.maps.size(); ++k) {
      expect(store::check_map(set.maps[k], set.stretches[k], names, "the maps"));
    }
  };
  std::visit(check, any);
}

void check(const Expected<AnyLog>& log, const std::string& file) {
  log ? check_log(*log) : check_error(log.error(), file);
}
void check(const Expected<AnyMapSet>& set, const std::string& file) {
  set ? check_maps(*set) : check_error(set.error(), file);
}

void check_round_trip(const AnyLog& any, LogFormat format) {
  static const testing::TemporaryFolder folder;
  const auto path = folder.path() / "written";
  const auto write_and_read = [&](const auto& log) {
    const bool has_edges = !log.odometry.empty() || !log.closures.empty();
    if (!has_edges && log.observations.empty() && log.initial_poses.empty()) return;  // There is nothing to write.
    if (!has_edges && format == LogFormat::kGtsam) return;                            // Taken for iSAM's without an edge.
    if (!write_log(log, format, path)) return;                                        // The format has no words for it.
    const auto read = open_log(path);
    promise(read.has_value(), "what was written reads back: " + (read ? "" : read.error().message));
    check_log(*read);
    if (losses(log, format).empty()) promise(bits_of(*read) == bits_of(any), "what is written without loss is the same");
  };
  std::visit(write_and_read, any);
}

}  // namespace mapjoin::fuzz
