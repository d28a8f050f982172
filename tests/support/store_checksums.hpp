// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The checksums of a store, for tests of what stands behind them.

#include <filesystem>
#include <mapjoin/io/store/database.hpp>

namespace mapjoin::testing {

/// Makes the checksums of a store right, whatever is in it; false if that fails.
inline bool seal(const std::filesystem::path& path) {
  auto database = store::Database::open(path);
  return database &&
         database->execute(
             "PRAGMA synchronous = OFF;"
             "UPDATE info SET crc32 = crc32(key, value); UPDATE records SET crc32 = crc32(name, data);"
             "UPDATE maps SET crc32 = crc32(segment, base, chi2, poses, features, pose_estimates, feature_estimates,"
             "                              information)");
}

}  // namespace mapjoin::testing
