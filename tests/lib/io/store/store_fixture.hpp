// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A store in a folder of its own, built from stored maps and read again.

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <mapjoin/io/store/store.hpp>
#include <tests/support/random.hpp>
#include <tests/support/temporary_folder.hpp>
#include <utility>
#include <variant>

namespace mapjoin::testing {

/// The page size of stores (bytes).
inline constexpr std::size_t kStorePage = 4096;

/// Builds a store, or goes on with an unfinished one; calls `after` with the number of maps done after each.
template <int Dim>
void build_store(const std::filesystem::path& path, const StoredMaps<Dim>& maps,
                 const std::function<void(std::size_t)>& after = {}) {
  auto writer = StoreWriter<Dim>::open(path, maps.log, maps.segments, maps.options);
  ASSERT_TRUE(writer) << writer.error().message;
  for (std::size_t k = writer->done().size(); k < maps.maps.size(); ++k) {
    ASSERT_TRUE(writer->add(k, maps.maps[k]));
    if (after) after(k + 1);
  }
  const auto finished = writer->finish();
  ASSERT_TRUE(finished) << finished.error().message;
}

template <int Dim>
std::size_t maps_done(const std::filesystem::path& path, const StoredMaps<Dim>& maps) {
  return StoreWriter<Dim>::open(path, maps.log, maps.segments, maps.options)->done().size();
}

/// A folder for a store of dimension D::value, which is read from there.
template <typename D>
class StoreTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  Expected<StoredMaps<kDim>> read() const {
    return read_store(path).map([](AnyStoredMaps&& any) { return std::get<StoredMaps<kDim>>(std::move(any)); });
  }
  TemporaryFolder folder;
  std::filesystem::path path = folder.path() / "maps.mapjoin";
  std::filesystem::path partial = folder.path() / "maps.mapjoin.partial";
  Random random;
};

}  // namespace mapjoin::testing
