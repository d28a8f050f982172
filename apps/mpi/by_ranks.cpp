// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/mpi/by_ranks.hpp>
#include <mapjoin/distributed/run.hpp>
#include <mapjoin/distributed/share_maps.hpp>
#include <mapjoin/model/lists.hpp>

namespace mapjoin::apps {

using distributed::Communicator;

ExitCode told_by_first(const Communicator& comm, const std::function<ExitCode()>& work) {
  Expected<int> code = 0;
  try {
    if (comm.is_root()) code = static_cast<int>(work());
  } catch (const tl::bad_expected_access<Error>& failure) {
    code = tl::unexpected(failure.error());
  }
  return static_cast<ExitCode>(comm.sum(static_cast<std::int64_t>(comm.agree(code).value())));
}

void describe(int dimension, const distributed::LogFigures& log, RunReport& run_report) {
  run_report.dimension = dimension;
  run_report.conventions = log.conventions;
  run_report.is_resumed = log.is_resumed;
  run_report.was_damaged = log.was_damaged;
  run_report.counts = log.counts;
}

std::string effort_in_words(const Communicator& comm) {
  const double most = comm.max(peak_memory_mb());
  return fmt::format("ranks         {}, of which the largest took {:.0f} MB\n", comm.size(), most);
}

ExitCode conclude(CommandRun& command_run, const std::string& effort) {
  const ExitCode code = command_run.conclude();
  if (command_run.options().has_summary()) demand(write_stdout(effort));
  return code;
}

/// The numbers of unknowns shared by ranks and by regions, in one line; for the first rank.
template <int Dim>
std::string shared_in_words(const MpiOptions& options, const distributed::Found<Dim>& found) {
  return fmt::format("shared        {} unknowns by ranks, {} by regions, {} a rank\n", found.shared_by_ranks,
                     found.shared_by_regions, options.regions);
}

/// Checks that the folder exists, on every rank: each may be on a machine of its own.
Expected<void> check_folder(const std::filesystem::path& out_of_core) {
  std::error_code ignored;
  if (out_of_core.empty() || std::filesystem::is_directory(out_of_core, ignored)) return {};
  return tl::unexpected(
      Error{ErrorKind::kUsage, fmt::format("--out-of-core: {} is no folder on every rank's machine", out_of_core.string())});
}

ExitCode make_map(const std::string& command, const MpiOptions& options, const MappedLogReader& read) {
  const Communicator comm(MPI_COMM_WORLD);
  CommandRun command_run(command, options, {});
  told_by_first(comm, [&] {
    command_run.prepare(outputs_of_map(options));
    return ExitCode::kDone;
  });
  demand(comm.agree(check_folder(options.out_of_core)));
  const distributed::Task task{
      options.run, {options.out_of_core}, options.most_memory_mb, static_cast<std::size_t>(options.regions)};
  const auto check_names = [&](const PoseIds& poses, const FeatureIds& features) { command_run.check_names(poses, features); };
  auto found = distributed::run(
                   comm, [&] { return read(comm, check_names); }, task)
                   .value();
  const std::string effort =
      std::visit([&](const auto& any) { return shared_in_words(options, any); }, found) + effort_in_words(comm);
  return told_by_first(comm, [&] {
    const auto write = [&]<int Dim>(distributed::Found<Dim>& any) {
      describe(Dim, any.log, command_run.run_report);
      command_run.write_map<Dim>(any.result, nullptr);
    };
    std::visit(write, found);
    return conclude(command_run, effort);
  });
}

std::vector<std::string> store_conflicts(const MpiOptions& options, const std::string& option) {
  std::vector<std::string> violations;
  if (options.stores.empty()) return violations;
  const Communicator comm(MPI_COMM_WORLD);
  NamedFiles files = inputs_of(options, "LOG");
  append(files, report_of(options));
  for (int rank = 0; rank < comm.size(); ++rank) {
    const std::filesystem::path store = distributed::store_of(rank, comm.size(), options.stores);
    append(violations, unfinished_conflicts(files, option, store));
    append(violations, unfinished_store_conflicts(files, option, store));
  }
  return violations;
}

void add_way_of_ranks(Subcommand& command, MpiOptions& options) {
  command.group("Joining");
  command.choice("--schedule", options.run.schedule, "How each rank joins its part before the parts are aligned");
  add_solver(command, options);
  command.group("Memory");
  command.number<std::int64_t>(
      "--regions", options.regions, 1, "N",
      "Regions of each rank, eliminated one after the other, of whose factors each thread holds one at a time");
  command.path("--out-of-core", options.out_of_core, "DIR",
               "Keep the factor in files in this folder, but for those of several regions");
  add_most_memory(command, options, "Refuse factors that take more on any rank [no bound]");
  add_reporting(command, options);
}

}  // namespace mapjoin::apps
