// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Whether a log that is spread over ranks hangs together.

#include <mapjoin/distributed/log_part.hpp>

namespace mapjoin::distributed {

/// As mapjoin::check_connected(), the same on all ranks. Of the factors of a rank, the first rank sees a spanning forest.
template <int Dim>
Expected<void> check_connected(const Communicator& comm, const LogPart<Dim>& part);

}  // namespace mapjoin::distributed
