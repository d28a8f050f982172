// SPDX-License-Identifier: BSD-3-Clause
#include <apps/map_file.hpp>
#include <mapjoin/io/g2o.hpp>
#include <mapjoin/io/map_text.hpp>
#include <mapjoin/io/output_file.hpp>
#include <system_error>

namespace mapjoin::apps {
namespace {

template <int Dim>
Expected<std::vector<std::string>> write_csv(const GlobalMap<Dim>& map, const std::filesystem::path& path) {
  std::vector<std::string> files = {path.string()};
  if (auto written = write_pose_csv(map, path); !written) return tl::unexpected(written.error());
  if (map.features.empty()) return files;
  const auto beside = std::filesystem::path(path).replace_extension(".features.csv");
  files.push_back(beside.string());
  return write_feature_csv(map, beside).map([&] { return files; });
}

}  // namespace

Expected<void> check_writable(const std::filesystem::path& path) {
  std::error_code ignored;
  if (path.empty() || (std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored))) return {};
  return OutputFile::create(path).map([](const OutputFile&) {});
}

template <int Dim>
Expected<std::vector<std::string>> write_map(const GlobalMap<Dim>& map, const Log<Dim>* log,
                                             const std::filesystem::path& path) {
  if (path.extension() == ".csv") return write_csv(map, path);
  const auto written = path.extension() == ".tum" ? write_tum(map, path) : write_g2o(map, log, path);
  return written.map([&] { return std::vector<std::string>{path.string()}; });
}

template Expected<std::vector<std::string>> write_map(const GlobalMap<2>&, const Log<2>*, const std::filesystem::path&);
template Expected<std::vector<std::string>> write_map(const GlobalMap<3>&, const Log<3>*, const std::filesystem::path&);

}  // namespace mapjoin::apps
