// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <mapjoin/io/system_call.hpp>
#include <system_error>

namespace mapjoin {

tl::unexpected<Error> call_failed(const std::filesystem::path& path, int reason, ErrorKind kind) {
  return tl::unexpected(Error{reason == EINTR ? ErrorKind::kInterrupted : kind,
                              fmt::format("{}: {}", path.string(), std::generic_category().message(reason))});
}

int write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ::ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0) return errno;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

}  // namespace mapjoin
