// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <mapjoin/io/files/archive.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/io/local_maps/local_map_file.hpp>
#include <mapjoin/io/mrclam/mrclam.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/io/run_folder.hpp>
#include <system_error>
#include <utility>

namespace mapjoin {

Expected<AnyLog> open_log(const std::filesystem::path& path, const ReadOptions& options) {
  if (is_mrclam_folder(path)) return options.turns_information() ? not_in_g2o(path.string()) : read_mrclam(path);
  if (is_run_folder(path)) return read_run_folder(path, options);
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return bad_input(path.string() +
                     ": a folder is a log if Barcodes.dat (of UTIAS MRCLAM) or map.g2o (of a run) is in it; `mapjoin join` "
                     "takes folders of localmap_<k>.mat or .txt");
  }
  return FileBytes::read(path).and_then([&](const FileBytes& bytes) { return read_log(bytes.view(), path.string(), options); });
}

namespace {

template <int Dim>
Expected<AnyLog> merged_as(std::vector<AnyLog> logs, const std::vector<std::filesystem::path>& paths,
                           const MergeOptions& options) {
  std::vector<Log<Dim>> same;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    auto* log = std::get_if<Log<Dim>>(&logs[k]);
    if (!log) return bad_input(fmt::format("{} is in {}D, but {} is not", paths.front().string(), Dim, paths[k].string()));
    same.push_back(std::move(*log));
  }
  return merged(std::move(same), options);
}

/// The portion that a store has; the whole for anything else.
Portion portion_of(const AnyMaps& any) {
  return std::visit(
      [](const auto& maps) {
        if constexpr (requires { maps.portion; }) return maps.portion;
        return Portion{};
      },
      any);
}

}  // namespace

Expected<AnyLog> open_logs(const std::vector<std::filesystem::path>& paths, ReadOptions options, const MergeOptions& merging) {
  if (paths.empty()) return tl::unexpected(Error{ErrorKind::kUsage, "no log is named"});
  if (paths.size() == 1) return open_log(paths.front(), options);
  if (options.undeclared == Undeclared::kRefused) options.undeclared = Undeclared::kForeign;
  std::vector<AnyLog> logs;
  for (const std::filesystem::path& path : paths) {
    auto log = open_log(path, options);
    if (!log) return log;
    logs.push_back(*std::move(log));
  }
  return std::holds_alternative<Log<2>>(logs.front()) ? merged_as<2>(std::move(logs), paths, merging)
                                                      : merged_as<3>(std::move(logs), paths, merging);
}

bool may_hold_maps(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return !is_mrclam_folder(path) && has_local_maps(path);
  if (!std::filesystem::is_regular_file(path, ignored)) return false;  // A pipe can be read only once.
  if (is_store(path)) return true;
  const auto bytes = FileBytes::read(path);
  return bytes && is_tar_archive(bytes->view());
}

Expected<AnyMaps> open_maps(const std::filesystem::path& path, const ReadOptions& options) {
  return open_maps_or_portion(path, options).and_then([&](AnyMaps any) -> Expected<AnyMaps> {
    const Portion portion = portion_of(any);
    if (portion.is_whole()) return any;
    return bad_input(fmt::format("{}: the store has portion {} of {} of its log: give those of all {} to `mapjoin join`",
                                 path.string(), portion.index + 1, portion.count, portion.count));
  });
}

Expected<AnyMaps> open_maps_or_portion(const std::filesystem::path& path, const ReadOptions& options) {
  if (!is_store(path)) {
    return read_local_map_set(path, options).map([](AnySubmapSet any) {
      return std::visit([](auto&& set) { return AnyMaps(std::move(set)); }, std::move(any));
    });
  }
  return read_store(path).map([&](AnyStoredMaps any) {
    const auto as_they_are = [&](auto&& stored) {
      return has_maps_alone(stored) ? AnyMaps(submap_set_of(std::move(stored), path)) : AnyMaps(std::move(stored));
    };
    return std::visit(as_they_are, std::move(any));
  });
}

}  // namespace mapjoin
