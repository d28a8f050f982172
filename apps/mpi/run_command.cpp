// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin-mpi run`: from a log to a global map, by all ranks together.

#include <apps/mpi/by_ranks.hpp>
#include <memory>

namespace mapjoin::apps {
namespace {

ExitCode run_log(const MpiOptions& options) {
  const auto read = [&](const distributed::Communicator& comm, const distributed::NamesCheck& check_names) {
    return distributed::mapped_log(comm,
                                   {options.input, options.read, options.covariance, options.run, options.stores, check_names});
  };
  return make_map("run", options, read);
}

}  // namespace

void declare_mpi_run(Subcommand& command) {
  command.examples(
      "  mpirun -n 2 mapjoin-mpi run data/manhattan2d.g2o -o map.g2o\n"
      "  mpirun -n 16 mapjoin-mpi run city.g2o -o map.csv --out-of-core /scratch --max-memory 8000\n"
      "  mpirun -n 16 mapjoin-mpi run city.g2o -o map.csv --checkpoint stores");
  const auto options = std::make_shared<MpiOptions>();
  command.argument("LOG", options->input, "The log, a plain g2o file that all ranks can read");
  command.path("-o,--output", options->output, "MAP", kMapFile);
  command.path(
      "--checkpoint", options->stores, "DIR",
      "Keep the local maps of each rank in a store in this folder, from which the same command goes on if it is killed");
  add_splitting(command, *options);
  add_reading(command, *options);
  add_way_of_ranks(command, *options);
  command.check([options] { return demand_extension(options->output); });
  command.check([options] { return output_conflicts(inputs_of(*options, "LOG"), outputs_of_map(*options)); });
  command.check([options] { return store_conflicts(*options, "--checkpoint"); });
  command.act([options](const std::stop_token&) { return run_log(*options); });
}

}  // namespace mapjoin::apps
