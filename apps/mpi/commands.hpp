// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The subcommands of `mapjoin-mpi`, each in a file of its own.

#include <apps/commands/subcommand.hpp>

namespace mapjoin::apps {

void declare_mpi_run(Subcommand& command);
void declare_mpi_build(Subcommand& command);
void declare_mpi_join(Subcommand& command);

}  // namespace mapjoin::apps
