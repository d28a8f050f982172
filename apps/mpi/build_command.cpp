// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin-mpi build`: from a log to the stores of all ranks' local maps.

#include <apps/mpi/by_ranks.hpp>
#include <mapjoin/distributed/share_maps.hpp>
#include <memory>

namespace mapjoin::apps {
namespace {

using distributed::Communicator;
using distributed::MappedLog;

ExitCode build_log(const MpiOptions& options) {
  const Communicator comm(MPI_COMM_WORLD);
  CommandRun command_run("build", options, {});
  told_by_first(comm, [&] {
    command_run.prepare(report_of(options));
    return ExitCode::kDone;
  });
  RunOptions run = options.run;
  if (run.split.rule == SplitRule::kAuto) run.split.amount = 2.0;  // maps of one step would be the log itself
  const auto log =
      distributed::mapped_log(comm, {options.input, options.read, options.covariance, run, options.stores}).value();
  const std::string effort = effort_in_words(comm);
  return told_by_first(comm, [&] {
    const auto tell = [&]<int Dim>(const MappedLog<Dim>& any) {
      describe(Dim, any.log, command_run.run_report);
      command_run.run_report.figures = any.figures;
    };
    std::visit(tell, log);
    command_run.run_report.has_local_maps = true;
    for (int rank = 0; rank < comm.size(); ++rank) {
      command_run.run_report.files.push_back(distributed::store_of(rank, comm.size(), options.stores).string());
    }
    return conclude(command_run, effort);
  });
}

}  // namespace

void declare_mpi_build(Subcommand& command) {
  command.examples(
      "  mpirun -n 16 mapjoin-mpi build city.g2o -o stores\n"
      "  mapjoin join stores/*.maps -o map.g2o");
  const auto options = std::make_shared<MpiOptions>();
  command.argument("LOG", options->input, "The log, a plain g2o file that all ranks can read");
  command.path(
      "-o,--output", options->stores, "DIR",
      "Write a store of each rank's part of the log and its local maps into this folder, from which the same command goes on "
      "if it is killed",
      true);
  add_splitting(command, *options);
  add_solver(command, *options);
  add_reading(command, *options);
  add_reporting(command, *options);
  command.check([options] { return output_conflicts(inputs_of(*options, "LOG"), report_of(*options)); });
  command.check([options] { return store_conflicts(*options, "--output"); });
  command.act([options](const std::stop_token&) { return build_log(*options); });
}

}  // namespace mapjoin::apps
