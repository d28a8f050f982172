// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/distributed/reading/log_part.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/model/faults.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/model/renumber.hpp>
#include <optional>
#include <sstream>
#include <utility>

namespace mapjoin::distributed {
namespace {

template <typename Index, typename Id>
Table<Index, Id> names_of_all(const Communicator& comm, Table<Index, Id> mine) {
  std::ranges::sort(mine);
  std::vector<Id> all = comm.gather<Id>(mine);
  make_distinct(all);
  return Table<Index, Id>(std::move(all));
}

template <typename Index, typename Id>
Index index_of(const Table<Index, Id>& names, const Id& id) {
  return Index(find_ascending(names, id).value());
}

/// Counts of the lines that the readers of all ranks left out.
SkipCounts skipped_by_all(const Communicator& comm, const SkipCounts& mine) {
  std::string lines;
  for (const auto& [what, count] : mine) lines += fmt::format("{} {}\n", count, what);
  SkipCounts all;
  for (const std::string& some : comm.gather(lines)) {
    std::istringstream text(some);
    std::int64_t count = 0;
    for (std::string what; text >> count && std::getline(text >> std::ws, what);) all[what] += count;
  }
  return all;
}

/// Repairs of matrices by the readers of all ranks.
MatrixRepairs repairs_by_all(const Communicator& comm, MatrixRepairs repairs) {
  for (const auto count : {&MatrixRepairs::symmetrised, &MatrixRepairs::indefinite, &MatrixRepairs::missing}) {
    repairs.*count = comm.sum(repairs.*count);
  }
  repairs.largest_asymmetry = comm.max(repairs.largest_asymmetry);
  return repairs;
}

/// The ids that vertices on all ranks declare, ascending; kBadInput if one is declared twice.
template <typename Id>
Expected<std::vector<std::uint64_t>> declared_by_all(const Communicator& comm, const std::string& file,
                                                     const std::vector<std::uint64_t>& declared_here) {
  std::vector<std::uint64_t> declared = comm.gather(declared_here);
  std::ranges::sort(declared);
  if (const auto twice = std::ranges::adjacent_find(declared); twice != declared.end()) {
    return bad_input(fmt::format("{}: {} is declared a second time; two logs in one file are to be given as two files", file,
                                 to_string(Id{.key = *twice})));
  }
  return declared;
}

/// Leaves out the edges of this rank to what no vertex declares, and counts them; takes such names out of `names`.
template <int Dim>
void leave_out_undeclared_edges(const Declared& declared, Log<Dim>& log, LogPart<Dim>& names) {
  const auto has_pose = [&](PoseIndex pose) { return pose == kWorld || declared.has_pose(log.poses[pose].key); };
  const auto has_feature = [&](FeatureIndex feature) { return declared.has_feature(log.features[feature].key); };
  const std::size_t count =
      std::erase_if(log.graph.pose_factors, [&](const auto& o) { return !has_pose(o.base) || !has_pose(o.target); }) +
      std::erase_if(log.graph.feature_factors, [&](const auto& o) { return !has_pose(o.base) || !has_feature(o.target); });
  if (count > 0) log.skipped[std::string(kEdgesToUndeclared)] += static_cast<std::int64_t>(count);
  std::erase_if(names.poses, [&](const PoseId& id) { return !declared.has_pose(id.key); });
  std::erase_if(names.features, [&](const FeatureId& id) { return !declared.has_feature(id.key); });
}

bool is_undeclared(std::uint64_t fixed, const Declared& declared) {
  return !declared.has_pose(fixed) && !declared.has_feature(fixed);
}

/// Leaves out the fixed poses that no vertex declares; the first rank counts them.
template <int Dim>
void leave_out_undeclared_fixed(const Communicator& comm, const Declared& declared, Log<Dim>& log,
                                std::vector<std::uint64_t>& fixed) {
  const std::size_t count = std::erase_if(fixed, [&](std::uint64_t key) { return is_undeclared(key, declared); });
  if (count > 0 && comm.rank() == 0) log.skipped[std::string(kFixedUndeclared)] += static_cast<std::int64_t>(count);
}

/// kBadInput, with the place of the first line of this rank that names what no vertex declares, if there is one among `names`.
template <int Dim>
Expected<void> check_declared(const TextPart& part, const Declared& declared, const LogPart<Dim>& names) {
  const bool are_declared = std::ranges::all_of(names.poses, declared.has_pose, &PoseId::key) &&
                            std::ranges::all_of(names.features, declared.has_feature, &FeatureId::key) &&
                            std::ranges::none_of(part.fixed, [&](std::uint64_t key) { return is_undeclared(key, declared); });
  if (are_declared) return {};
  const TextScanner text(names.source, part.text, part.lines_before);
  const auto missing = first_undeclared_in_g2o<Dim>(text, declared);
  if (!missing) return {};  // a FIX line of another rank names it
  return text.error(
      missing->place,
      fmt::format("the file declares vertices, but not {}; --skip-undeclared leaves such lines out", missing->name));
}

/// Settles what the lines of this rank, whose names are given, say of undeclared poses and features in a file with vertices: as
/// for a reader of the whole file. kBadInput, the same on all ranks.
template <int Dim>
Expected<void> settle_undeclared(const Communicator& comm, TextPart& part, Undeclared undeclared, Log<Dim>& log,
                                 LogPart<Dim>& names) {
  const auto poses = declared_by_all<PoseId>(comm, names.source, part.declared_poses);
  if (!poses) return tl::unexpected(poses.error());
  const auto features = declared_by_all<FeatureId>(comm, names.source, part.declared_features);
  if (!features) return tl::unexpected(features.error());
  const Declared declared{[&](std::uint64_t key) { return std::ranges::binary_search(*poses, key); },
                          [&](std::uint64_t key) { return std::ranges::binary_search(*features, key); }};
  if (undeclared == Undeclared::kRefused) return comm.agree(check_declared(part, declared, names));
  leave_out_undeclared_edges(declared, log, names);
  leave_out_undeclared_fixed(comm, declared, log, part.fixed);
  return {};
}

/// The log in the lines of this rank; nullopt if they mention no pose or feature.
Expected<std::optional<AnyLog>> log_of(const TextPart& part, const std::string& file, const ReadOptions& options) {
  if (!part.has_graph) return std::nullopt;
  const std::string with_parameters = part.parameters.empty() ? std::string() : part.parameters + std::string(part.text);
  const auto before = static_cast<std::size_t>(std::ranges::count(part.parameters, '\n'));
  // Line numbers go on from those before, less the parameter lines of others; unsigned wrap-around makes that safe.
  const TextScanner text(file, with_parameters.empty() ? part.text : with_parameters, part.lines_before - before);
  return read_g2o(text, options, {.is_whole = false, .needs_poses = false}).map([](AnyLog log) {
    return std::optional(std::move(log));
  });
}

/// kBadInput, with its place, if a FIX line of this rank, not left out, names no pose of the log or, in a file without
/// vertices, which give them values, a second one.
template <int Dim>
Expected<void> check_fixed(const TextPart& part, const LogPart<Dim>& whole, bool has_vertices) {
  const auto is_unknown = [&](std::uint64_t key) { return !find_ascending(whole.poses, PoseId{0, key}); };
  const auto is_second = [&](std::uint64_t key) { return !has_vertices && key != part.first_fixed; };
  if (std::ranges::none_of(part.fixed, [&](std::uint64_t key) { return is_unknown(key) || is_second(key); })) return {};
  const TextScanner text(whole.source, part.text, part.lines_before);
  for (const auto& [key, place] : fixed_names(text)) {
    if (!std::ranges::binary_search(part.fixed, key)) continue;
    const PoseId id{0, key};
    if (is_unknown(key)) return text.error(place, fixed_without_pose(id));
    if (is_second(key)) return text.error(place, fixed_nowhere(id, PoseId{0, *part.first_fixed}));
  }
  return {};  // another rank has the line
}

/// The fixed poses, at the values of their vertices.
template <int Dim>
Expected<std::vector<FixedPose<Dim>>> fixed_poses(const Communicator& comm, const TextPart& part, const LogPart<Dim>& log,
                                                  const std::vector<std::uint64_t>& fixed, const ReadOptions& options) {
  if (fixed.empty()) return {};
  std::string vertices;
  for (const std::string& some : comm.gather(part.vertices_of(fixed))) vertices += some;
  LogBuilder<Dim> builder(log.source);
  if (!vertices.empty()) {
    auto values = read_g2o(TextScanner(log.source, vertices), options);
    if (!values) return tl::unexpected(values.error());
    builder.append(std::get<Log<Dim>>(*values));
  }
  for (const std::uint64_t key : fixed) {
    builder.add_pose({0, key});
    builder.fix({0, key});
  }
  return std::move(builder).finish(PoseOrder::kOfIds).map([&](Log<Dim> said) {
    for (auto& pose : said.graph.fixed) pose.pose = index_of(log.poses, said.poses[pose.pose]);
    return std::move(said.graph.fixed);
  });
}

/// The factors of one rank's log, moved out of it, by the indices of all names.
template <int Dim>
FactorGraph<Dim> renumbered(Log<Dim>& log, const LogPart<Dim>& whole) {
  FactorGraph<Dim> graph{std::move(log.graph.pose_factors), std::move(log.graph.feature_factors), {}, {}};
  renumber(graph, EachKind{[&](PoseIndex p) { return index_of(whole.poses, log.poses[p]); },
                           [&](FeatureIndex f) { return index_of(whole.features, log.features[f]); }});
  return graph;
}

/// Ids of the poses that fix the gauge: those of FIX lines; otherwise, if nothing is measured from the World, the first pose of
/// a file with vertices, if it has any, at its own value.
template <int Dim>
std::vector<std::uint64_t> poses_to_fix(const Communicator& comm, const TextPart& part, const LogPart<Dim>& log,
                                        bool has_vertices) {
  const auto is_prior = [](const auto& o) { return o.base == kWorld; };
  const bool has_priors =
      std::ranges::any_of(log.graph.pose_factors, is_prior) || std::ranges::any_of(log.graph.feature_factors, is_prior);
  const bool is_held = comm.any(has_priors) || !part.fixed.empty();
  return is_held || !has_vertices || log.poses.empty() ? part.fixed : std::vector{log.poses.front().key};
}

template <int Dim>
Expected<AnyLogPart> log_part(const Communicator& comm, TextPart& part, Log<Dim> log, const std::string& file,
                              const ReadOptions& options) {
  LogPart<Dim> whole{file, log.conventions, {}, log.poses, log.features, {}};
  whole.conventions.repairs = repairs_by_all(comm, log.conventions.repairs);
  const bool has_vertices = comm.any(!part.declared_poses.empty() || !part.declared_features.empty());
  const auto settled = has_vertices ? settle_undeclared(comm, part, options.undeclared, log, whole) : Expected<void>();
  if (!settled) return tl::unexpected(settled.error());
  whole.skipped = skipped_by_all(comm, log.skipped);
  whole.poses = names_of_all(comm, std::move(whole.poses));
  whole.features = names_of_all(comm, std::move(whole.features));
  whole.graph = renumbered(log, whole);
  if (const auto known = comm.agree(check_fixed(part, whole, has_vertices)); !known) return tl::unexpected(known.error());
  auto fixed = fixed_poses(comm, part, whole, poses_to_fix(comm, part, whole, has_vertices), options);
  if (!fixed) return tl::unexpected(fixed.error());
  whole.graph.fixed = *std::move(fixed);
  return AnyLogPart(std::move(whole));
}

}  // namespace

Expected<AnyLogPart> read_log_part(const Communicator& comm, const std::filesystem::path& path, const ReadOptions& options) {
  auto part = read_text_part(comm, path);
  if (!part) return tl::unexpected(part.error());
  auto log = comm.agree(log_of(*part, path.string(), options));
  if (!log) return tl::unexpected(log.error());
  const bool is_in_space = comm.any(*log && std::holds_alternative<Log<3>>(**log));
  if (is_in_space && comm.any(*log && std::holds_alternative<Log<2>>(**log))) {
    return bad_input(path.string() + ": the file has lines of the plane and lines of space");
  }
  const auto of_dimension = [&]<int Dim>(Log<Dim> none) {
    return log_part<Dim>(comm, *part, *log ? std::get<Log<Dim>>(**std::move(log)) : std::move(none), path.string(), options);
  };
  return is_in_space ? of_dimension(Log<3>{}) : of_dimension(Log<2>{});
}

}  // namespace mapjoin::distributed
