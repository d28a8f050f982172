// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <mapjoin/distributed/start.hpp>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/align/gauge.hpp>
#include <mapjoin/model/lists.hpp>
#include <span>
#include <utility>

namespace mapjoin::distributed {
namespace {

template <int Dim>
std::string encoded(const std::vector<Outline<Dim>>& outlines) {
  Writer writer;
  for (const auto& o : outlines) {
    writer.put(std::vector{o.anchor})
        .put(o.poses)
        .put(o.features)
        .put(o.values.poses)
        .put(o.values.features)
        .put(o.observations);
  }
  return std::move(writer).bytes();
}

template <int Dim>
std::vector<Outline<Dim>> decoded_outlines(const std::string& bytes) {
  std::vector<Outline<Dim>> outlines;
  for (Reader reader(bytes); !reader.is_at_end();) {
    auto& o = outlines.emplace_back();
    o.anchor = reader.take<PoseIndex>().front();
    o.poses = reader.take<PoseIndex>();
    o.features = reader.take<FeatureIndex>();
    o.values.poses.std::template vector<Pose<Dim>>::operator=(reader.take<Pose<Dim>>());
    o.values.features.std::template vector<Point<Dim>>::operator=(reader.take<Point<Dim>>());
    o.observations = reader.take<FeatureFactor<Dim>>();
  }
  return outlines;
}

template <int Dim>
PartialMap<Dim> partial_of(const Outline<Dim>& outline) {
  PartialMap<Dim> partial{
      Table<PoseIndex, PoseIndex>(outline.poses), Table<FeatureIndex, FeatureIndex>(outline.features), outline.values, {}};
  for (const auto& o : outline.observations) partial.factors.feature_factors.push_back(&o);
  return partial;
}

/// The outlines of consecutive ranks, merged as far as they are tied.
template <int Dim>
std::vector<PartialMap<Dim>> merged(std::span<const std::vector<Outline<Dim>>> ranks,
                                    const std::vector<const PoseFactor<Dim>*>& closures) {
  std::vector<PartialMap<Dim>> partials;
  if (ranks.size() == 1) {
    std::ranges::transform(ranks.front(), std::back_inserter(partials), partial_of<Dim>);
    return partials;
  }
  const std::size_t half = ranks.size() / 2;
  for (const auto& some : {ranks.first(half), ranks.subspan(half)}) {
    std::ranges::move(merged<Dim>(some, closures), std::back_inserter(partials));
  }
  return merge_tied(std::move(partials), closures, true);
}

/// The frames of all ranks' outlines, one after the other.
template <int Dim>
std::vector<Pose<Dim>> aligned(const std::vector<std::vector<Outline<Dim>>>& ranks, const GlobalFactors<Dim>& factors) {
  SubmapGraph<Dim> world;
  world.fixed = factors.fixed;
  for (const auto& prior : factors.priors) world.priors.pose_factors.push_back(&prior);
  std::vector<const PoseFactor<Dim>*> closures;
  for (const auto& closure : factors.closures) closures.push_back(&closure);
  std::vector<PartialMap<Dim>> partials = merged<Dim>(ranks, closures);
  for (auto& partial : partials) place_in_world(world, Pose<Dim>{}, partial);

  std::vector<Pose<Dim>> frames;
  for (const auto& outlines : ranks) {
    for (const auto& outline : outlines) {
      const auto own = std::ranges::lower_bound(outline.poses, outline.anchor) - outline.poses.begin();
      const auto holder = std::ranges::find_if(partials, [&](const auto& p) { return holds(p.poses, outline.anchor); });
      frames.push_back(compose(pose_in(*holder, outline.anchor), inverse(outline.values.poses[PoseIndex(own)])));
    }
  }
  return frames;
}

}  // namespace

template <int Dim>
std::vector<PoseIndex> GlobalFactors<Dim>::poses() const {
  std::vector<PoseIndex> all;
  for (const auto& o : closures) all.insert(all.end(), {o.base, o.target});
  for (const auto& o : priors) all.push_back(o.target);
  for (const auto& f : fixed) all.push_back(f.pose);
  make_distinct(all);
  return all;
}

template <int Dim>
std::vector<Pose<Dim>> frames_of(const Communicator& comm, const std::vector<Outline<Dim>>& outlines,
                                 const GlobalFactors<Dim>& factors) {
  const std::vector<std::string> from = comm.collect(encoded(outlines));
  std::string frames;
  if (comm.is_root()) {
    std::vector<std::vector<Outline<Dim>>> ranks;
    std::ranges::transform(from, std::back_inserter(ranks), decoded_outlines<Dim>);
    frames = Writer().put(aligned(ranks, factors)).bytes();
  }
  frames = comm.broadcast(std::move(frames), 0);
  const std::vector<Pose<Dim>> all = Reader(frames).take<Pose<Dim>>();
  const auto counts = comm.gather(std::vector<std::uint64_t>{outlines.size()});
  auto first = all.begin();
  for (int r = 0; r < comm.rank(); ++r) first += static_cast<std::ptrdiff_t>(counts[static_cast<std::size_t>(r)]);
  return {first, first + static_cast<std::ptrdiff_t>(outlines.size())};
}

#define MAPJOIN_INSTANTIATE(Dim)      \
  template struct GlobalFactors<Dim>; \
  template std::vector<Pose<Dim>> frames_of(const Communicator&, const std::vector<Outline<Dim>>&, const GlobalFactors<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::distributed
