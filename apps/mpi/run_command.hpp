// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// `mapjoin-mpi run`.

#include <apps/commands/subcommand.hpp>

namespace mapjoin::apps {

void declare_mpi_run(Subcommand& command);

}  // namespace mapjoin::apps
