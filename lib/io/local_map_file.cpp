// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <mapjoin/io/local_map_file.hpp>
#include <mapjoin/io/mat_file.hpp>
#include <mapjoin/io/mat_structure.hpp>

namespace mapjoin {
namespace {

/// The numbers of a text one after the other, whatever white space is between them.
class Numbers {
 public:
  Numbers(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  /// The next number. The first that is malformed or missing is remembered, and from it on all are 0.
  template <typename T>
  T next() {
    skip_space();
    T value{};
    const char* begin = text_.data() + position_;
    const char* end = text_.data() + text_.size();
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error != std::errc() || (stop != end && !is_space(*stop))) {
      fail(begin == end ? "the file ends here, but a number is missing" : "not a number of the kind expected here");
      return T{};
    }
    position_ += static_cast<std::size_t>(stop - begin);
    return value;
  }
  /// At most this many numbers are left.
  std::size_t capacity() const { return (text_.size() - position_ + 1) / 2; }
  void expect_end() {
    skip_space();
    if (position_ < text_.size()) fail("more than the information matrix");
  }
  /// Remembers what is wrong at this place; the first counts.
  void fail(const std::string& message) {
    if (error_) return;
    const std::string_view before = text_.substr(0, position_);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const auto column = before.size() - (before.rfind('\n') + 1) + 1;
    error_ = Error{ErrorKind::kBadInput, fmt::format("{}:{}:{}: {}", file_, line, column, message)};
    position_ = text_.size();
  }
  const std::optional<Error>& error() const { return error_; }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }
  void skip_space() {
    while (position_ < text_.size() && is_space(text_[position_])) ++position_;
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t position_ = 0;
  std::optional<Error> error_;
};

/// Linear SLAM's text.
Expected<LocalMapFile> parse_text(LocalMapFile&& map, std::string_view text) {
  const std::string file = map.path.string();
  Numbers numbers(text, file);
  const auto start = numbers.next<std::int64_t>();
  if (start != map.number - 1) {
    numbers.fail(fmt::format("the start pose is {}, but by the file's name it is {}", start, map.number - 1));
  }
  const auto n = numbers.next<std::size_t>();
  // n² does not overflow: n is at most half the text's length first.
  if (n > numbers.capacity() || n * n + 2 * n > numbers.capacity()) {
    numbers.fail(fmt::format("the file is too short for {} rows and their information matrix", n));
  }
  if (numbers.error()) return tl::unexpected(*numbers.error());

  const auto rows = static_cast<Eigen::Index>(n);
  map.state.resize(rows, 2);
  for (Eigen::Index row = 0; row < rows; ++row) {
    map.state(row, 0) = static_cast<double>(numbers.next<std::int64_t>());
    map.state(row, 1) = numbers.next<double>();
  }
  map.gaussian.resize(rows, rows);
  // Row by row in the file, column by column in memory: the matrix is symmetric, or refused.
  for (double& entry : map.gaussian.reshaped()) entry = numbers.next<double>();
  map.is_information = true;
  numbers.expect_end();
  if (numbers.error()) return tl::unexpected(*numbers.error());
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

Expected<LocalMapFile> parse_local_map(const std::filesystem::path& path, std::string_view bytes) {
  const auto number = local_map_number(path.filename().string());
  if (!number) return bad_input(fmt::format("{}: not named localmap_<k>.mat or localmap_<k>.txt", path.string()));
  LocalMapFile map;
  map.path = path;
  map.number = *number;
  return is_mat_file(bytes) ? parse_mat(std::move(map), bytes) : parse_text(std::move(map), bytes);
}

}  // namespace mapjoin
