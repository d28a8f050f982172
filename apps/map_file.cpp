// SPDX-License-Identifier: BSD-3-Clause
#include <apps/map_file.hpp>
#include <cerrno>
#include <mapjoin/io/g2o.hpp>
#include <mapjoin/io/map_text.hpp>
#include <mapjoin/io/output_file.hpp>
#include <mapjoin/io/system_call.hpp>
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

bool names_map_file(const fs::path& path) {
  const fs::path extension = path.extension();
  std::error_code ignored;
  return (extension == ".g2o" || extension == ".tum" || extension == ".csv") && !fs::is_directory(path, ignored);
}

std::vector<fs::path> map_files(const fs::path& path) {
  if (path.extension() != ".csv") return {path};
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
  const auto written = files.size() > 1             ? write_csv(map, files[0], files[1])
                       : path.extension() == ".tum" ? write_tum(map, path)
                                                    : write_g2o(map, log, path);
  return written.map([&] { return std::vector<std::string>(files.begin(), files.end()); });
}

template Expected<std::vector<std::string>> write_map_file(const GlobalMap<2>&, const Log<2>*, const fs::path&);
template Expected<std::vector<std::string>> write_map_file(const GlobalMap<3>&, const Log<3>*, const fs::path&);

}  // namespace mapjoin::apps
