// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/localmap/stored_build.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/version.hpp>
#include <span>

namespace mapjoin {
namespace {

constexpr std::size_t kMapsAtOnce = 256;  // Maps built before they are stored: few to lose, enough for all threads.

/// Builds the maps of some segments, in parallel, and stores them.
template <int Dim>
Expected<std::int64_t> build_some(StoreWriter<Dim>& store, const Log<Dim>& log, const Split& parts,
                                  std::span<const std::size_t> segments, const MinimiseOptions& solver,
                                  const std::stop_token& stop) {
  std::vector<BuiltMap<Dim>> built(segments.size());
  parallel_for(built.size(), [&](std::size_t i) {
    if (stop.stop_requested()) return;
    built[i] = build_local_map(segment_view(log, parts, parts.segments[segments[i]]), solver, stop);
  });
  if (stop.stop_requested()) return interrupted();
  std::int64_t iterations = 0;
  for (std::size_t i = 0; i < built.size(); ++i) {
    iterations += built[i].iterations;
    if (auto added = store.add(segments[i], built[i].map); !added) return tl::unexpected(added.error());
  }
  return iterations;
}

}  // namespace

std::string build_settings(const MinimiseOptions& solver) {
  return fmt::format("mapjoin {} --method {} --max-iterations {}, until {} of chi2, {} m and {} rad{}", kVersion,
                     to_string(solver.method), solver.max_iterations, solver.relative_chi2, solver.step_metres,
                     solver.step_radians, solver.damp_singular ? ", damped if singular" : "");
}

template <int Dim>
Expected<std::int64_t> build_into(StoreWriter<Dim>& store, const Log<Dim>& log, const Split& parts, const BuildOptions& options,
                                  const std::stop_token& stop) {
  const std::vector<std::size_t> to_do(store.to_do().begin(), store.to_do().end());
  const std::size_t all = store.done().size() + to_do.size();
  std::int64_t iterations = 0;
  for (std::size_t begin = 0; begin < to_do.size(); begin += kMapsAtOnce) {
    const auto some = std::span(to_do).subspan(begin, std::min(kMapsAtOnce, to_do.size() - begin));
    const auto added = build_some(store, log, parts, some, options.solver, stop);
    if (!added) return added;
    iterations += *added;
    if (options.progress) options.progress(store.done().size(), all);
  }
  return iterations;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                    \
  template Expected<std::int64_t> build_into(StoreWriter<Dim>&, const Log<Dim>&, const Split&, const BuildOptions&, \
                                             const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
