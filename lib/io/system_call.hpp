// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the operating system says of a call that failed, and a write that is whole.

#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <string_view>

namespace mapjoin {

/// `path: ` and the errno `reason` in words; kInterrupted where it is EINTR, for a signal without SA_RESTART ends a call that
/// waits, else `kind`.
tl::unexpected<Error> call_failed(const std::filesystem::path& path, int reason, ErrorKind kind);

/// Writes all bytes to a file descriptor. The errno of the first failure, or 0.
int write_all(int descriptor, std::string_view bytes);

}  // namespace mapjoin
