// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin-mpi run`: from a log to a global map, by all ranks together.

#include <fmt/format.h>

#include <apps/mpi/by_ranks.hpp>
#include <apps/mpi/commands.hpp>
#include <mapjoin/distributed/run.hpp>
#include <memory>

namespace mapjoin::apps {
namespace {

using distributed::Communicator;
using distributed::Found;

constexpr const char* kExamples =
    "  mpirun -n 2 mapjoin-mpi run data/manhattan2d.g2o -o map.g2o\n"
    "  mpirun -n 16 mapjoin-mpi run city.g2o -o map.csv --out-of-core /scratch --max-memory 8000\n"
    "  mpirun -n 16 mapjoin-mpi run city.g2o -o map.csv --checkpoint stores";

/// What the first rank knows of what regions share, in one line.
template <int Dim>
std::string shared_in_words(const MpiOptions& options, const Found<Dim>& found) {
  return fmt::format("shared        {} unknowns by ranks, {} by regions, {} a rank\n", found.shared_by_ranks,
                     found.shared_by_regions, options.regions);
}

ExitCode run_log(const MpiOptions& options) {
  const Communicator comm(MPI_COMM_WORLD);
  CommandRun command_run("run", options, {});
  told_by_first(comm, [&] {
    command_run.prepare(outputs_of_map(options));
    return ExitCode::kDone;
  });
  const distributed::LogTask log{options.input, options.read, options.covariance, options.run, options.stores};
  const auto read = [&] { return distributed::mapped_log(comm, log); };
  auto found =
      distributed::run(comm, read,
                       {options.run, {options.out_of_core}, options.most_memory_mb, static_cast<std::size_t>(options.regions)})
          .value();
  const std::string effort =
      std::visit([&](const auto& any) { return shared_in_words(options, any); }, found) + effort_in_words(comm);
  return told_by_first(comm, [&] {
    const auto write = [&]<int Dim>(Found<Dim>& any) {
      describe(Dim, any.log, command_run.run_report);
      command_run.write_map<Dim>(any.result, nullptr);
    };
    std::visit(write, found);
    return conclude(command_run, effort);
  });
}

}  // namespace

void declare_mpi_run(Subcommand& command) {
  command.examples(kExamples);
  const auto options = std::make_shared<MpiOptions>();
  command.argument("LOG", options->input, "The log, a plain g2o file that all ranks can read");
  command.path("-o,--output", options->output, "MAP", kMapFile);
  command.path(
      "--checkpoint", options->stores, "DIR",
      "Keep the local maps of each rank in a store in this folder, from which the same command goes on if it is killed");
  add_splitting(command, *options);
  command.choice("--schedule", options->run.schedule, "How each rank joins its part before the parts are aligned");
  add_solver(command, *options);
  add_reading(command, *options);
  add_memory(command, *options);
  add_reporting(command, *options);
  command.check([options] { return check_extension(options->output); });
  command.check([options] { return output_conflicts(inputs_of(*options, "LOG"), outputs_of_map(*options)); });
  command.act([options](const std::stop_token&) { return run_log(*options); });
}

}  // namespace mapjoin::apps
