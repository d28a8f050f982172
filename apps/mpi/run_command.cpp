// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin-mpi run`: from a log to a global map, by all ranks together. The first one tells.

#include <fmt/format.h>

#include <apps/commands/command_run.hpp>
#include <apps/mpi/run_command.hpp>
#include <mapjoin/distributed/run.hpp>
#include <memory>

namespace mapjoin::apps {
namespace {

using distributed::Communicator;
using distributed::Found;

constexpr const char* kExamples =
    "  mpirun -n 2 mapjoin-mpi run data/manhattan2d.g2o -o map.g2o\n"
    "  mpirun -n 16 mapjoin-mpi run city.g2o -o map.csv --out-of-core /scratch --max-memory 8000";

struct MpiOptions : Options {
  MpiOptions() { jobs = 1; }
  std::filesystem::path out_of_core;
};

/// What `work` returns on the first rank, on all of them; its failure, too.
ExitCode told_by_first(const Communicator& comm, const std::function<ExitCode()>& work) {
  Expected<int> code = 0;
  try {
    if (comm.is_root()) code = static_cast<int>(work());
  } catch (const tl::bad_expected_access<Error>& failure) {
    code = tl::unexpected(failure.error());
  }
  return static_cast<ExitCode>(comm.sum(static_cast<std::int64_t>(comm.agree(code).value())));
}

/// What ranks need, in one line.
std::string effort_in_words(const Communicator& comm) {
  const double most = comm.max(peak_memory_mb());
  return fmt::format("ranks         {}, of which the largest took {:.0f} MB\n", comm.size(), most);
}

template <int Dim>
void describe(const Found<Dim>& found, RunReport& run_report) {
  run_report.dimension = Dim;
  run_report.conventions = found.conventions;
  run_report.counts = {.sessions = 1,
                       .poses = found.result.map.poses.size(),
                       .features = found.result.map.features.size(),
                       .odometry = static_cast<std::size_t>(found.counts.odometry),
                       .closures = static_cast<std::size_t>(found.counts.closures),
                       .observations = static_cast<std::size_t>(found.counts.observations),
                       .priors = static_cast<std::size_t>(found.counts.priors),
                       .fixed_poses = static_cast<std::size_t>(found.counts.fixed_poses),
                       .skipped = found.counts.skipped};
}

ExitCode run_log(const MpiOptions& options) {
  const Communicator comm(MPI_COMM_WORLD);
  CommandRun command_run("run", options, {});
  told_by_first(comm, [&] {
    command_run.prepare(outputs_of_map(options));
    return ExitCode::kDone;
  });
  const distributed::Task task{options.input, options.read, options.run, {options.out_of_core}, options.most_memory_mb};
  auto found = distributed::run(comm, task).value();
  const std::string effort = effort_in_words(comm);
  return told_by_first(comm, [&] {
    const auto write = [&]<int Dim>(Found<Dim>& any) {
      describe(any, command_run.run_report);
      command_run.write_map<Dim>(any.result, nullptr);
    };
    std::visit(write, found);
    const ExitCode code = command_run.conclude();
    if (!options.quiet && !options.report_on_stdout()) demand(write_stdout(effort));
    return code;
  });
}

}  // namespace

void declare_mpi_run(Subcommand& command) {
  command.examples(kExamples);
  const auto options = std::make_shared<MpiOptions>();
  command.argument("LOG", options->input, "The log, a plain g2o file that all ranks can read");
  command.path("-o,--output", options->output, "MAP", kMapFile);
  add_splitting(command, *options);
  command.choice("--schedule", options->run.schedule, "How each rank joins its part before the parts are aligned");
  add_solver(command, *options);
  add_reading(command, *options);
  command.group("Memory");
  command.path("--out-of-core", options->out_of_core, "DIR", "Keep the factor of what regions share in files in this folder");
  command.number("--max-memory", options->most_memory_mb, 0.0, "MB", "Refuse factors that take more on any rank [no bound]");
  add_reporting(command, *options);
  command.check([options]() -> std::vector<std::string> {
    if (options->out_of_core.empty() || std::filesystem::is_directory(options->out_of_core)) return {};
    return {fmt::format("--out-of-core: {} is no folder", options->out_of_core.string())};
  });
  command.check([options] { return check_extension(options->output); });
  command.check([options] { return output_conflicts(inputs_of(*options, "LOG"), outputs_of_map(*options)); });
  command.act([options](const std::stop_token&) { return run_log(*options); });
}

}  // namespace mapjoin::apps
