// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin-mpi join`: from stores of local maps to a global map, by all ranks together.

#include <apps/mpi/by_ranks.hpp>
#include <memory>
#include <variant>

namespace mapjoin::apps {
namespace {

ExitCode join_stores(const MpiOptions& options) {
  std::vector<std::filesystem::path> stores{options.input};
  stores.insert(stores.end(), options.further.begin(), options.further.end());
  const auto read = [&](const distributed::Communicator& comm, const distributed::NamesCheck& check_names) {
    return distributed::stored_log(comm, stores).map([&](distributed::AnyMappedLog any) {
      std::visit([&](const auto& log) { check_names(log.whole.poses, log.whole.features); }, any);
      return any;
    });
  };
  return make_map("join", options, read);
}

}  // namespace

void declare_mpi_join(Subcommand& command) {
  command.examples(
      "  mpirun -n 16 mapjoin-mpi build city.g2o -o stores\n"
      "  mpirun -n 4 mapjoin-mpi join stores/*.maps -o map.g2o");
  const auto options = std::make_shared<MpiOptions>();
  command.argument("STORE", options->input, "A store of `mapjoin build` or `mapjoin-mpi build` that all ranks can read");
  command.further(options->further, "The stores of the other parts of the same log");
  command.path("-o,--output", options->output, "MAP", kMapFile);
  add_way_of_ranks(command, *options);
  command.check([options] { return demand_extension(options->output); });
  command.check([options] { return output_conflicts(inputs_of(*options, "STORE"), outputs_of_map(*options)); });
  command.act([options](const std::stop_token&) { return join_stores(*options); });
}

}  // namespace mapjoin::apps
