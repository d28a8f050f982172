// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <mapjoin/check/checks.hpp>
#include <mapjoin/distributed/mapped_log.hpp>
#include <mapjoin/measure/effort.hpp>
#include <span>
#include <utility>

namespace mapjoin::distributed {
namespace {

template <int Dim>
LogFigures figures_of(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
                      const ShareMaps<Dim>& maps) {
  std::vector<PoseFactor<Dim>> closures_apart;
  std::ranges::copy_if(share.apart.pose_factors, std::back_inserter(closures_apart),
                       [](const auto& o) { return o.base != kWorld; });
  const auto between = std::ssize(closures_apart);
  const auto sum = [&](std::ptrdiff_t mine) { return static_cast<std::size_t>(comm.sum(std::int64_t{mine})); };
  const StepCounts mine = count_steps(share.log);
  const StepCounts steps{sum(static_cast<std::ptrdiff_t>(mine.all)), sum(static_cast<std::ptrdiff_t>(mine.repeated))};
  LogFigures log{whole.conventions, {}};
  log.counts = {.sessions = sum(std::ssize(share.log.sessions)) - static_cast<std::size_t>(comm.size() - 1),  // see LogShare
                .poses = whole.poses.size(),
                .features = whole.features.size(),
                .odometry = sum(std::ssize(share.log.odometry())),
                .closures = sum(std::ssize(share.log.closures()) + between),
                .observations = sum(std::ssize(share.log.observations())),
                .priors = sum(std::ssize(share.apart.pose_factors) - between + std::ssize(share.apart.feature_factors)),
                .fixed_poses = whole.graph.fixed.size(),
                .repeated_edges = comm.sum(share.log.repeated_edges + count_repeated(std::span(std::as_const(closures_apart)))),
                .skipped = whole.skipped,
                .repeated_steps = steps.driven_twice()};
  log.is_resumed = comm.any(maps.is_resumed);
  log.was_damaged = comm.any(maps.was_damaged);
  return log;
}

template <int Dim>
RunFigures figures_of(const Communicator& comm, const ShareMaps<Dim>& maps) {
  RunFigures figures;
  figures.build_iterations = comm.sum(maps.iterations);
  figures.local_maps = static_cast<std::size_t>(comm.sum(std::ssize(maps.maps)));
  figures.raw_segments = static_cast<std::size_t>(comm.sum(std::ssize(maps.split.segments))) - figures.local_maps;
  return figures;
}

template <int Dim>
Expected<AnyMappedLog> mapped(const Communicator& comm, const LogTask& task, LogPart<Dim> whole) {
  const auto fit = check_worth_it(comm, whole.source, whole.poses, 1).and_then([&] { return check_connected(comm, whole); });
  if (!fit) return tl::unexpected(fit.error());
  if (task.check_names) task.check_names(whole.poses, whole.features);
  if (task.covariance == Covariance::kIdentity) use_identity_covariance(whole);
  LogShare<Dim> share = share_of(comm, whole, even_begins(whole.poses.size(), comm.size()), PoseOrder::kDriven);
  double seconds = 0.0;
  auto maps = [&] {
    const Stopwatch watch(seconds);
    return task.stores.empty() ? comm.agree(built_maps(share, task.run))
                               : stored_maps(comm, whole, share, task.run, task.stores);
  }();
  if (!maps) return tl::unexpected(maps.error());
  MappedLog<Dim> log = mapped_log(comm, std::move(whole), std::move(share), *std::move(maps));
  log.figures.seconds.build = seconds;
  return log;
}

}  // namespace

template <int Dim>
MappedLog<Dim> mapped_log(const Communicator& comm, LogPart<Dim> whole, LogShare<Dim> share, ShareMaps<Dim> maps) {
  const LogFigures log = figures_of(comm, whole, share, maps);
  const RunFigures figures = figures_of(comm, maps);
  return {std::move(whole), std::move(share), std::move(maps), log, figures};
}

Expected<AnyMappedLog> mapped_log(const Communicator& comm, const LogTask& task) {
  const auto ready = task.stores.empty() ? Expected<void>() : prepare_stores(comm, task.stores);
  return ready.and_then([&] { return read_log_part(comm, task.log, task.read); }).and_then([&](AnyLogPart part) {
    return std::visit([&](auto& any) { return mapped(comm, task, std::move(any)); }, part);
  });
}

template MappedLog<2> mapped_log(const Communicator&, LogPart<2>, LogShare<2>, ShareMaps<2>);
template MappedLog<3> mapped_log(const Communicator&, LogPart<3>, LogShare<3>, ShareMaps<3>);

}  // namespace mapjoin::distributed
