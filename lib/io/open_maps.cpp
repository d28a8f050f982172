// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/open_maps.hpp>
#include <utility>

namespace mapjoin {

Expected<AnyMaps> open_maps(const std::filesystem::path& path, const ReadOptions& options) {
  const auto widen = [](auto&& any) {
    return std::visit([](auto&& maps) { return AnyMaps(std::move(maps)); }, std::forward<decltype(any)>(any));
  };
  if (is_store(path)) return read_store(path).map(widen);
  return read_local_map_set(path, options).map(widen);
}

}  // namespace mapjoin
