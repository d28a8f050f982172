// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/archive.hpp>
#include <mapjoin/io/file_bytes.hpp>
#include <mapjoin/io/mrclam.hpp>
#include <mapjoin/io/open_maps.hpp>
#include <mapjoin/io/store_map_set.hpp>
#include <system_error>
#include <utility>

namespace mapjoin {

bool may_hold_maps(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return !is_mrclam_folder(path);
  if (!std::filesystem::is_regular_file(path, ignored)) return false;  // A pipe can be read only once.
  if (is_store(path)) return true;
  const auto bytes = FileBytes::read(path);
  return bytes && is_tar_archive(bytes->view());
}

Expected<AnyMaps> open_maps(const std::filesystem::path& path, const ReadOptions& options) {
  if (!is_store(path)) {
    return read_local_map_set(path, options).map([](AnyMapSet any) {
      return std::visit([](auto&& set) { return AnyMaps(std::move(set)); }, std::move(any));
    });
  }
  return read_store(path).map([&](AnyStoredMaps any) {
    const auto as_they_are = [&](auto&& stored) {
      return has_maps_alone(stored) ? AnyMaps(map_set_of(std::move(stored), path)) : AnyMaps(std::move(stored));
    };
    return std::visit(as_they_are, std::move(any));
  });
}

}  // namespace mapjoin
