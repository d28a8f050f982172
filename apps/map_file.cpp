// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/map_file.hpp>
#include <cerrno>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/system_call.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <system_error>

namespace mapjoin::apps {
namespace fs = std::filesystem;

Expected<void> check_writable(const fs::path& path) {
  std::error_code ignored;
  if (path.empty()) return {};
  if (fs::is_directory(path, ignored)) return call_failed(path, EISDIR, ErrorKind::kCannotWrite);
  if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored)) return {};
  return OutputFile::create(path).map([](const OutputFile&) {});
}

std::string extension_of(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

bool names_map_file(const fs::path& path) {
  const std::string extension = extension_of(path);
  std::error_code ignored;
  return (extension == ".g2o" || extension == ".tum" || extension == ".csv") && !fs::is_directory(path, ignored);
}

std::vector<std::string> check_extension(const fs::path& path) {
  std::error_code ignored;
  const bool is_special = fs::exists(path, ignored) && !fs::is_regular_file(path, ignored);
  if (is_special || !path.has_extension() || names_map_file(path)) return {};
  return {
      fmt::format("--output: {} has none of the extensions of a map, .g2o, .tum and .csv (a new folder has none, or ends in /)",
                  path.string())};
}

std::vector<fs::path> map_files(const fs::path& path) {
  if (extension_of(path) != ".csv") return {path};
  return {path, fs::path(path).replace_extension(".features.csv")};
}

Expected<void> check_map_writable(const fs::path& path) {
  Expected<void> writable;
  for (const fs::path& file : map_files(path)) writable = writable.and_then([&] { return check_writable(file); });
  return writable;
}

template <int Dim>
Expected<std::vector<std::string>> write_map_file(const GlobalMap<Dim>& map, const Log<Dim>* log, const fs::path& path) {
  const std::vector<fs::path> files = map_files(path);
  const auto written = files.size() > 1               ? write_csv(map, files[0], files[1])
                       : extension_of(path) == ".tum" ? write_tum(map, path)
                                                      : write_g2o(map, log, path);
  return written.map([&] { return std::vector<std::string>(files.begin(), files.end()); });
}

template Expected<std::vector<std::string>> write_map_file(const GlobalMap<2>&, const Log<2>*, const fs::path&);
template Expected<std::vector<std::string>> write_map_file(const GlobalMap<3>&, const Log<3>*, const fs::path&);

}  // namespace mapjoin::apps
