// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <fstream>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/g2o/growing_g2o.hpp>
#include <tests/fuzz/choices.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::fuzz {
namespace {

/// The number of edges and observations.
std::size_t size_of(const AnyLog& any) {
  return std::visit([](const auto& log) { return log.edges().size() + log.observations().size(); }, any);
}

using Part = Expected<std::optional<AnyLog>>;

/// Adds the size of a part to `taken`; false if the part is an error.
bool take(const Part& part, const std::string& file, std::size_t& taken) {
  if (!part) check_error(part.error(), file);
  if (!part || !*part) return part.has_value();
  check_log(**part);
  taken += size_of(**part);
  return true;
}

}  // namespace

/// Follows a file whose bytes arrive piece by piece, which must give the log of all of them.
void growing_g2o(std::string_view bytes) {
  static const testing::TemporaryFolder folder;
  const auto [options, eighth] = choices(bytes);
  const std::size_t piece_bytes = 8 * eighth;
  const std::string path = folder.file("growing.g2o", "");
  std::ofstream file(path, std::ios::binary | std::ios::app);
  auto growing = GrowingG2o::open(path, options);
  promise(growing.has_value(), "a plain file can be followed");
  std::size_t taken = 0;
  bool right = true;
  for (std::size_t at = 0; right && at < bytes.size(); at += piece_bytes) {
    file << bytes.substr(at, piece_bytes) << std::flush;
    right = take(growing->appended(), path, taken);
  }
  if (right) right = take(growing->rest(), path, taken);
  const auto whole = read_g2o(TextScanner(path, bytes), options);
  if (!whole || taken == 0) return;
  // An observation may come before the parameters that it names.
  if (!right && bytes.find("PARAMS_") != bytes.npos) return;
  promise(right, "parts are right where the whole is");
  promise(taken == size_of(*whole), "parts are the whole");
  const auto followed = growing->whole();
  promise(followed && bits_of(*followed) == bits_of(*whole), "what was followed is the whole");
}

}  // namespace mapjoin::fuzz
