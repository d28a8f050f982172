// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/distributed/mapped_log.hpp>
#include <mapjoin/io/store/pieces.hpp>
#include <mapjoin/measure/effort.hpp>
#include <optional>
#include <utility>

namespace mapjoin::distributed {
namespace {

using Paths = std::vector<std::filesystem::path>;

/// The stores of one log.
template <int Dim>
struct Stores {
  std::vector<StorePieces> pieces;
  StoredMaps<Dim> outline;           ///< Outline of the first store; a segment is a map if any store has one.
  std::vector<std::size_t> holders;  ///< The store that has its map, by segment.
};

tl::unexpected<Error> usage(const std::string& sentence) {
  return tl::unexpected(Error{ErrorKind::kUsage, sentence});
}

/// Opens all stores; each is checked by one of the ranks.
Expected<std::vector<StorePieces>> opened(const Communicator& comm, const Paths& paths) {
  std::vector<StorePieces> pieces;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    auto store = StorePieces::open(paths[k]);
    if (!store) return tl::unexpected(store.error());
    const bool is_mine = k % static_cast<std::size_t>(comm.size()) == static_cast<std::size_t>(comm.rank());
    if (const auto sound = is_mine ? store->check() : Expected<void>(); !sound) return tl::unexpected(sound.error());
    pieces.push_back(*std::move(store));
  }
  return pieces;
}

/// The dimension of all stores; kBadInput if they differ.
Expected<int> dimension_of(std::vector<StorePieces>& pieces, const Paths& paths) {
  const auto first = pieces.front().dimension();
  for (std::size_t k = 1; first && k < pieces.size(); ++k) {
    const auto dimension = pieces[k].dimension();
    if (!dimension) return dimension;
    if (*dimension == *first) continue;
    return bad_input(fmt::format("{} and {} are not of one dimension", paths.front().string(), paths[k].string()));
  }
  return first;
}

/// Adds the maps that another store of the same log has.
template <int Dim>
Expected<void> add_segments(Stores<Dim>& stores, const StoredMaps<Dim>& other, std::size_t k) {
  auto& segments = stores.outline.segments;
  if (auto alike = check_cut_alike(segments, other.segments, stores.outline.log.source); !alike) return alike;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    if (segments[s].is_map || !other.segments[s].is_map) continue;
    segments[s].is_map = true;
    stores.holders[s] = k;
  }
  return {};
}

/// The stores of one log. Each rank checks for some of them that they have the same log.
template <int Dim>
Expected<Stores<Dim>> one_log(const Communicator& comm, std::vector<StorePieces> pieces, const Paths& paths) {
  auto outline = pieces.front().outline<Dim>();
  if (!outline) return tl::unexpected(outline.error());
  Stores<Dim> stores{std::move(pieces), *std::move(outline), {}};
  stores.holders.resize(stores.outline.segments.size(), 0);
  std::vector<Portion> portions{stores.outline.portion};
  for (std::size_t k = 1; k < paths.size(); ++k) {
    const auto other = stores.pieces[k].template outline<Dim>();
    if (!other) return tl::unexpected(other.error());
    const bool are_whole = other->portion.is_whole() && portions.front().is_whole();
    bool is_same = are_whole || other->options == stores.outline.options;
    if (is_same && k % static_cast<std::size_t>(comm.size()) == static_cast<std::size_t>(comm.rank())) {
      const auto found = stores.pieces[k].has_log_of(stores.pieces.front(), are_whole);
      if (!found) return tl::unexpected(found.error());
      is_same = *found;
    }
    if (!is_same) {
      return usage(
          fmt::format("{} and {} are not of one log: `mapjoin join` takes several", paths.front().string(), paths[k].string()));
    }
    if (const auto added = add_segments(stores, *other, k); !added) return tl::unexpected(added.error());
    portions.push_back(other->portion);
  }
  const bool are_whole = std::ranges::all_of(portions, &Portion::is_whole);
  const auto fit = are_whole ? Expected<void>() : check_complete(std::move(portions), stores.outline.log.source);
  return fit.map([&] { return std::move(stores); });
}

/// This rank's part of the factors of the log, as they stand in the stores.
template <int Dim>
Expected<FactorGraph<Dim>> some_factors(const Communicator& comm, Stores<Dim>& stores) {
  std::vector<std::vector<std::int64_t>> chunks;
  std::size_t count = 0;
  const std::size_t having = stores.outline.portion.is_whole() ? 1 : stores.pieces.size();
  for (std::size_t k = 0; k < having; ++k) {
    auto some = stores.pieces[k].factor_chunks();
    if (!some) return tl::unexpected(some.error());
    count += some->size();
    chunks.push_back(*std::move(some));
  }
  if (count == 0) return usage(stores.outline.log.source + ": the store has local maps alone: `mapjoin join` takes them");
  const auto first_of = [&](int rank) {
    return count * static_cast<std::size_t>(rank) / static_cast<std::size_t>(comm.size());
  };
  std::size_t begin = first_of(comm.rank());
  std::size_t end = first_of(comm.rank() + 1);
  FactorGraph<Dim> graph;
  for (std::size_t k = 0; k < having; ++k) {
    const std::size_t size = chunks[k].size();
    const auto mine = std::span(chunks[k]).subspan(std::min(begin, size), std::min(end, size) - std::min(begin, size));
    if (auto read = stores.pieces[k].read_factors(mine, graph); !read) return tl::unexpected(read.error());
    begin -= std::min(begin, size);
    end -= std::min(end, size);
  }
  return graph;
}

/// Checks the factors of an untrusted store: kBadInput if they are inconsistent.
template <int Dim>
Expected<void> check_factors(const Log<Dim>& names, const FactorGraph<Dim>& graph) {
  if (graph.pose_factors.empty() && graph.feature_factors.empty()) return {};
  const std::string source = names.source + ": damaged store";
  Log<Dim> log;
  log.poses = names.poses;
  log.features = names.features;
  log.graph = graph;
  LogBuilder<Dim> builder(source);
  try {
    builder.append(log);
  } catch (const std::out_of_range&) {
    return bad_input(source + ": its arrays do not hang together; build it again");
  }
  return std::move(builder).finish(PoseOrder::kOfIds).map([](const Log<Dim>&) {}).map_error([](const Error& error) {
    return Error{error.kind, error.message + "; build it again"};
  });
}

/// The first poses of the shares, each where one segment ends and the next begins: at the first such pose from an even cut on,
/// or before it if the shares behind would have none.
Expected<std::vector<PoseIndex>> begins_of(const std::vector<Segment>& segments, std::size_t poses, int ranks,
                                           const std::string& source) {
  std::vector<PoseIndex> meetings;
  for (std::size_t k = 1; k < segments.size(); ++k) {
    if (segments[k].begin == segments[k - 1].end) meetings.push_back(segments[k].begin);
  }
  const std::vector<PoseIndex> even = even_begins(poses, ranks);
  if (meetings.size() + 1 < even.size()) {
    return usage(fmt::format("{}: its segments meet at {}, too few for {}", source, plural(meetings.size(), "pose"),
                             plural(ranks, "rank")));
  }
  std::vector<PoseIndex> begins{0};
  auto next = meetings.begin();
  for (std::size_t r = 1; r < even.size(); ++r, ++next) {
    const auto last = meetings.end() - static_cast<std::ptrdiff_t>(even.size() - r);
    next = std::lower_bound(next, last, even[r]);
    begins.push_back(*next);
  }
  return begins;
}

/// The maps of a share, from the stores that have them.
template <int Dim>
Expected<ShareMaps<Dim>> read_maps(Stores<Dim>& stores, const LogShare<Dim>& share) {
  const auto& segments = stores.outline.segments;
  const auto is_mine = [&](const Segment& s) { return share.poses.front() <= s.begin && s.end <= share.poses.back(); };
  std::vector<Segment> mine;
  std::vector<std::optional<LocalMap<Dim>>> maps;
  std::vector<std::size_t> places(segments.size());  // places of their maps in `maps`
  for (std::size_t s = 0; s < segments.size(); ++s) {
    if (!is_mine(segments[s])) continue;
    const std::int32_t first = share.poses.front().value;
    mine.push_back({segments[s].begin - first, segments[s].end - first, segments[s].is_map});
    places[s] = maps.size();
    if (segments[s].is_map) maps.emplace_back();
  }
  for (std::size_t k = 0; k < stores.pieces.size(); ++k) {
    std::vector<Segment> of_store = segments;
    for (std::size_t s = 0; s < segments.size(); ++s) of_store[s].is_map &= is_mine(segments[s]) && stores.holders[s] == k;
    auto some = stores.pieces[k].maps(stores.outline.log, of_store);
    if (!some) return tl::unexpected(some.error());
    auto map = some->begin();
    for (std::size_t s = 0; s < segments.size(); ++s) {
      if (of_store[s].is_map) maps[places[s]] = std::move(*map++);
    }
  }
  ShareMaps<Dim> read{split_along(share.log, std::move(mine)), {}};
  for (const PoseIndex p : indices(share.poses)) read.split.kept[p] = read.split.kept[p] || share.is_referenced[p];
  return take_maps(share, std::move(maps), read).map([&] { return std::move(read); });
}

template <int Dim>
Expected<AnyMappedLog> mapped(const Communicator& comm, std::vector<StorePieces> pieces, const Paths& paths) {
  auto stores = comm.agree(one_log<Dim>(comm, std::move(pieces), paths));
  if (!stores) return tl::unexpected(stores.error());
  const Log<Dim>& log = stores->outline.log;
  auto begins = begins_of(stores->outline.segments, log.poses.size(), comm.size(), log.source);
  if (!begins) return tl::unexpected(begins.error());
  auto graph = comm.agree(some_factors(comm, *stores).and_then([&](FactorGraph<Dim> some) {
    return check_factors(log, some).map([&] { return std::move(some); });
  }));
  if (!graph) return tl::unexpected(graph.error());
  graph->fixed = log.graph.fixed;
  LogPart<Dim> whole{log.source, log.conventions, log.skipped, log.poses, log.features, *std::move(graph)};
  if (auto tied = check_connected(comm, whole); !tied) return tl::unexpected(tied.error());
  LogShare<Dim> share = share_of(comm, whole, *begins, PoseOrder::kOfIds);
  auto maps = comm.agree(read_maps(*stores, share));
  if (!maps) return tl::unexpected(maps.error());
  return mapped_log(comm, std::move(whole), std::move(share), *std::move(maps));
}

}  // namespace

Expected<AnyMappedLog> stored_log(const Communicator& comm, const Paths& paths) {
  auto pieces = comm.agree(opened(comm, paths));
  if (!pieces) return tl::unexpected(pieces.error());
  const auto dimension = comm.agree(dimension_of(*pieces, paths));
  if (!dimension) return tl::unexpected(dimension.error());
  return *dimension == 2 ? mapped<2>(comm, *std::move(pieces), paths) : mapped<3>(comm, *std::move(pieces), paths);
}

}  // namespace mapjoin::distributed
