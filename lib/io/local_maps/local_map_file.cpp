// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/local_maps/local_map_file.hpp>
#include <system_error>

namespace mapjoin {
namespace {

/// Reads the next line with `read`; bad input if the file ends where `what` is expected.
template <typename Read>
Expected<void> take_line(TextScanner& text, const char* what, const Read& read) {
  if (!text.next_line()) return text.error(fmt::format("the file ends where {} is expected", what));
  read();
  return text.finish_line();
}

/// Reads the first two lines: the start pose, which must be that of the file's name, and the number of rows, which the file
/// must have room for.
Expected<std::size_t> parse_text_header(TextScanner& text, std::int64_t start) {
  std::size_t rows = 0;
  return take_line(text, "the start pose",
                   [&] {
                     if (text.integer() != start) text.reject(fmt::format("by the file's name the start pose is {}", start));
                   })
      .and_then([&] {
        return take_line(text, "the number of rows", [&] {
          rows = text.key();
          // Every number takes at least two bytes. The first comparison keeps the product from overflowing.
          const std::size_t most = text.size() / 2 + 1;
          if (rows > most || rows * rows + 2 * rows > most) text.reject("the file is too short for so many rows");
        });
      })
      .map([&] { return rows; });
}

/// Reads Linear SLAM's text.
Expected<LocalMapFile> parse_text(LocalMapFile&& map, std::string_view bytes) {
  TextScanner text(map.path.string(), bytes);
  const auto header = parse_text_header(text, map.number - 1);
  if (!header) return tl::unexpected(header.error());
  const auto rows = static_cast<Eigen::Index>(*header);
  map.state.resize(rows, 2);
  map.gaussian.resize(rows, rows);
  map.is_information = true;

  Expected<void> line;
  for (Eigen::Index row = 0; row < rows && line; ++row) {
    line = take_line(text, "a row of the state", [&] {
      const auto id = static_cast<double>(text.integer());
      if (std::abs(id) >= kDoubleIdEnd) text.reject("an id must be below 2^53");
      map.state(row, 0) = id;
      map.state(row, 1) = text.number();
    });
  }
  for (Eigen::Index row = 0; row < rows && line; ++row) {
    line = take_line(text, "a row of the information matrix", [&] {
      for (double& entry : map.gaussian.row(row)) entry = text.number();
    });
  }
  if (!line) return tl::unexpected(line.error());
  if (text.next_line()) return text.error("the file goes on behind the information matrix");
  return std::move(map);
}

Expected<LocalMapFile> parse_mat(LocalMapFile&& map, std::string_view bytes) {
  const std::string file = map.path.string();
  auto variables = read_mat(bytes, file, {"localmap_st", "localmap_P", "st", "I", "Ref"});
  if (!variables) return tl::unexpected(variables.error());
  map.is_information = variables->contains("I");
  const char* state_name = map.is_information ? "st" : "localmap_st";
  const char* gaussian_name = map.is_information ? "I" : "localmap_P";
  const auto state = variables->find(state_name);
  const auto gaussian = variables->find(gaussian_name);
  if (state == variables->end() || gaussian == variables->end()) {
    return bad_input(fmt::format("{}: holds neither localmap_st and localmap_P nor st and I", file));
  }
  if (state->second.cols() != 2) {
    return bad_input(fmt::format("{}: variable {} has {} columns, not 2", file, state_name, state->second.cols()));
  }
  const auto start = variables->find("Ref");
  if (start != variables->end() && (start->second.size() != 1 || start->second(0) != static_cast<double>(map.number - 1))) {
    return bad_input(fmt::format("{}: variable Ref is not the start pose by the file's name, {}", file, map.number - 1));
  }
  map.state = state->second;
  map.gaussian = std::move(gaussian->second);
  return std::move(map);
}

}  // namespace

std::optional<std::int64_t> local_map_number(const std::string& file_name) {
  constexpr std::string_view kPrefix = "localmap_";
  std::string_view name = file_name;
  if (!name.starts_with(kPrefix)) return std::nullopt;
  name.remove_prefix(kPrefix.size());
  std::int32_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc() || number < 0) return std::nullopt;
  name.remove_prefix(static_cast<std::size_t>(end - name.data()));
  if (name.ends_with(".gz")) name.remove_suffix(3);
  return name == ".mat" || name == ".txt" ? std::optional<std::int64_t>(number) : std::nullopt;
}

bool has_local_maps(const std::filesystem::path& folder) {
  std::error_code failure;
  for (std::filesystem::directory_iterator entry(folder, failure), end; !failure && entry != end; entry.increment(failure)) {
    if (local_map_number(entry->path().filename().string())) return true;
  }
  return false;
}

Expected<LocalMapFile> parse_local_map(const std::filesystem::path& path, std::string_view bytes) {
  const auto number = local_map_number(path.filename().string());
  if (!number) return bad_input(fmt::format("{}: not named localmap_<k>.mat or localmap_<k>.txt", path.string()));
  if (*number < 1) return bad_input(fmt::format("{}: local maps are counted from 1", path.string()));
  LocalMapFile map;
  map.path = path;
  map.number = *number;
  return is_mat_file(bytes) ? parse_mat(std::move(map), bytes) : parse_text(std::move(map), bytes);
}

}  // namespace mapjoin
