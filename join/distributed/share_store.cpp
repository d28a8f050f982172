// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <mapjoin/distributed/share_maps.hpp>
#include <mapjoin/io/store/pieces.hpp>
#include <mapjoin/io/store/store.hpp>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/localmap/stored_build.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/model/renumber.hpp>
#include <regex>
#include <span>
#include <string>
#include <utility>

namespace mapjoin::distributed {
namespace {

namespace fs = std::filesystem;

/// The contents of a rank's store besides its maps.
template <int Dim>
struct Portioned {
  Log<Dim> log;  ///< All poses and features, by the indices of all names, and the factors of this rank.
  Split split;   ///< The segments of all ranks; only those of this rank may be maps.
  std::string options{};
  Portion portion{};
};

template <int Dim>
Log<Dim> portion_of(const LogPart<Dim>& whole, const LogShare<Dim>& share) {
  Log<Dim> log;
  log.source = whole.source;
  log.poses = whole.poses;
  log.features = whole.features;
  log.conventions = whole.conventions;
  log.skipped = whole.skipped;
  log.graph = share.log.graph;
  renumber(log.graph, [&](auto place) { return index_in(share, place); });
  append(log.graph.pose_factors, share.apart.pose_factors);
  append(log.graph.feature_factors, share.apart.feature_factors);
  log.graph.fixed = whole.graph.fixed;
  put_in_order(log);
  return log;
}

/// The segments of all shares in their order. A single pose where two shares meet is no segment if the other share has a
/// segment there.
template <int Dim>
std::vector<Segment> segments_of_all(const Communicator& comm, const LogShare<Dim>& share, std::vector<Segment> mine) {
  for (Segment& segment : mine) {
    segment.begin = share.poses[segment.begin];
    segment.end = share.poses[segment.end];
  }
  const std::vector<Segment> all = comm.gather(mine);
  std::vector<Segment> segments;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Segment& segment = all[k];
    const bool is_of_last = !segments.empty() && segments.back().end == segment.begin;
    const bool is_of_next = k + 1 < all.size() && all[k + 1].begin == segment.begin;
    if (segment.begin == segment.end && (is_of_last || is_of_next)) continue;
    segments.push_back(segment);
    segments.back().is_map &= share.poses.front() <= segment.begin && segment.end <= share.poses.back();
  }
  return segments;
}

/// The checksum of records as a store holds them, computed in pieces.
template <typename List>
std::uint64_t checksum(const List& records) {
  constexpr std::size_t kAtOnce = 4096;
  boost::crc_optimal<64, 0x42F0E1EBA9EA3693> crc;  // polynomial of ECMA-182
  for (std::size_t k = 0; k < records.size(); k += kAtOnce) {
    const std::string bytes = store::encode_all(std::span(records).subspan(k, std::min(kAtOnce, records.size() - k)));
    crc.process_bytes(bytes.data(), bytes.size());
  }
  return crc.checksum();
}

/// A fingerprint of the factors of all ranks: maps keep the poses that other portions mention, so that none may be of another
/// log.
template <int Dim>
std::uint64_t fingerprint(const Communicator& comm, const Log<Dim>& log) {
  return checksum(comm.gather(std::vector{checksum(log.graph.pose_factors), checksum(log.graph.feature_factors)}));
}

template <int Dim>
Portioned<Dim> portioned(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share, const Split& parts,
                         const MinimiseOptions& solver) {
  Portioned<Dim> portioned{portion_of(whole, share), {segments_of_all(comm, share, parts.segments), {}, parts.poses_per_map}};
  portioned.split.kept.resize(whole.poses.size(), false);
  for (const PoseIndex p : indices(share.poses)) portioned.split.kept[share.poses[p]] = parts.kept[p];
  portioned.options = fmt::format("{}, log {:016x}", build_settings(solver), fingerprint(comm, portioned.log));
  portioned.portion = {static_cast<std::size_t>(comm.rank()), static_cast<std::size_t>(comm.size())};
  return portioned;
}

/// The finished store at `path`; nullopt if it does not hold these contents.
template <int Dim>
std::optional<StorePieces> finished_store(const fs::path& path, const Portioned<Dim>& of) {
  auto pieces = StorePieces::open(path);
  if (!pieces || !pieces->check()) return std::nullopt;
  const auto is_this = pieces->template holds<Dim>({of.log, of.split.segments, of.options, of.portion});
  return is_this && *is_this ? std::optional(*std::move(pieces)) : std::nullopt;
}

/// Builds the maps that a store lacks, and finishes it.
template <int Dim>
Expected<StorePieces> build_store(const fs::path& path, const Portioned<Dim>& of, const MinimiseOptions& solver,
                                  ShareMaps<Dim>& maps) {
  auto store = StoreWriter<Dim>::open(path, of.log, of.split.segments, of.options, of.portion);
  if (!store) return tl::unexpected(store.error());
  maps.is_resumed = !store->done().empty();
  maps.was_damaged = store->found_damaged();
  const auto iterations = build_into(*store, of.log, of.split, {solver, nullptr});
  if (!iterations) return tl::unexpected(iterations.error());
  maps.iterations = *iterations;
  return store->finish().and_then([&] { return StorePieces::open(path); });
}

/// Takes the maps of a share from its store.
template <int Dim>
Expected<void> take_maps(StorePieces& store, const Portioned<Dim>& of, const LogShare<Dim>& share, ShareMaps<Dim>& into) {
  return store.maps(of.log, of.split.segments).and_then([&](auto maps) { return take_maps(share, std::move(maps), into); });
}

/// The number of ranks in the name of a store, finished or not; nullopt for other names.
std::optional<int> ranks_of(const std::string& name) {
  static const std::regex store("[0-9]+-of-([0-9]{1,9})\\.maps(\\.partial)?");
  std::smatch match;
  return std::regex_match(name, match, store) ? std::optional(std::stoi(match[1])) : std::nullopt;
}

Expected<void> prepare(const fs::path& folder, int ranks) {
  std::error_code error;
  fs::create_directories(folder, error);
  fs::directory_iterator entry(folder, error);
  if (error) return tl::unexpected(Error{ErrorKind::kCannotWrite, folder.string() + ": " + error.message()});
  for (; entry != fs::directory_iterator(); entry.increment(error)) {
    const auto others = ranks_of(entry->path().filename().string());
    if (!others || *others == ranks) continue;
    return tl::unexpected(Error{ErrorKind::kUsage, fmt::format("{}: the folder has stores of {}, and this is called on {}: "
                                                               "go on with as many, or take another folder",
                                                               folder.string(), plural(*others, "rank"), ranks)});
  }
  if (error) return tl::unexpected(Error{ErrorKind::kCannotWrite, folder.string() + ": " + error.message()});
  return {};
}

}  // namespace

fs::path store_of(int rank, int ranks, const fs::path& folder) {
  return folder / fmt::format("{}-of-{}.maps", rank + 1, ranks);
}

Expected<void> prepare_stores(const Communicator& comm, const fs::path& folder) {
  return comm.agree(prepare(folder, comm.size()));
}

template <int Dim>
Expected<ShareMaps<Dim>> stored_maps(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
                                     const RunOptions& options, const fs::path& folder) {
  if (comm.any(!std::ranges::is_sorted(share.poses))) {
    return tl::unexpected(Error{
        ErrorKind::kUsage, whole.source + ": its poses were not driven in the order of their ids, which the stores of ranks "
                                          "have no place for: `mapjoin build` takes it"});
  }
  ShareMaps<Dim> maps{split(share.log, options.split, share.is_referenced), {}};
  const Portioned<Dim> of = portioned(comm, whole, share, maps.split, options.solver);
  const fs::path path = store_of(comm.rank(), comm.size(), folder);
  Expected<void> taken;
  if (auto finished = finished_store(path, of)) {
    maps.is_resumed = true;
    taken = take_maps(*finished, of, share, maps);
  } else {
    taken = build_store(path, of, options.solver, maps).and_then([&](StorePieces store) {
      return take_maps(store, of, share, maps);
    });
  }
  return comm.agree(std::move(taken)).map([&] { return std::move(maps); });
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                \
  template Expected<ShareMaps<Dim>> stored_maps(const Communicator&, const LogPart<Dim>&, const LogShare<Dim>&, \
                                                const RunOptions&, const std::filesystem::path&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::distributed
