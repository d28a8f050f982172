// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <mapjoin/distributed/reading/text_part.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/model/lists.hpp>

namespace mapjoin::distributed {
namespace {

constexpr std::string_view kBlanks = " \t\r";

/// Takes the first word off a line.
std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

/// The id that a word is; 0 for another word, which the reader of the line rejects.
std::uint64_t id_in(std::string_view word) {
  std::uint64_t id = 0;
  std::from_chars(word.data(), word.data() + word.size(), id);
  return id;
}

/// Calls f(line with its end, its first word, the rest of it) for every line, until it returns true.
template <typename F>
void find_line(std::string_view text, F&& f) {
  while (!text.empty()) {
    const std::size_t size = std::min(text.find('\n'), text.size() - 1) + 1;
    const std::string_view line = text.substr(0, size);
    text.remove_prefix(size);
    std::string_view rest = line.substr(0, line.ends_with('\n') ? size - 1 : size);
    const std::string_view tag = take_word(rest);
    if (f(line, tag, rest)) return;
  }
}

/// Calls f(line with its end, its first word, the rest of it) for every line.
template <typename F>
void for_each_line(std::string_view text, F&& f) {
  find_line(text, [&](std::string_view line, std::string_view tag, std::string_view rest) {
    f(line, tag, rest);
    return false;
  });
}

bool is_pose_vertex(std::string_view tag) {
  return tag == "VERTEX_SE2" || tag == "VERTEX_SE3:QUAT";
}
bool is_feature_vertex(std::string_view tag) {
  return tag == "VERTEX_XY" || tag == "VERTEX_TRACKXYZ";
}

/// The lines whose first byte lies in range `rank` of `size`.
std::string_view range_of(std::string_view text, int rank, int size) {
  const auto line_from = [&](int r) {
    const std::size_t begin = text.size() * static_cast<std::size_t>(r) / static_cast<std::size_t>(size);
    if (begin == 0) return begin;
    return std::min(text.find('\n', begin - 1), text.size() - 1) + 1;
  };
  return text.substr(line_from(rank), line_from(rank + 1) - line_from(rank));
}

Expected<FileBytes> plain_g2o(const std::filesystem::path& path) {
  return FileBytes::read(path).and_then([&](FileBytes bytes) -> Expected<FileBytes> {
    std::string_view first;
    find_line(bytes.view(), [&](std::string_view, std::string_view tag, std::string_view) {
      if (!tag.starts_with('#')) first = tag;
      return !first.empty();
    });
    if (is_g2o_tag(first)) return bytes;
    return bad_input(fmt::format(
        "{}: ranks read their parts of a plain g2o file, and this is none; `mapjoin convert` writes one, or `mapjoin build` a "
        "store for `mapjoin-mpi join`",
        path.string()));
  });
}

/// Findings of a rank in its lines for all ranks.
struct SaidOfAll {
  std::vector<std::uint64_t> fixed;
  std::string parameters;
  std::uint64_t lines = 0;
};

SaidOfAll scan(TextPart& part) {
  SaidOfAll said;
  for_each_line(part.text, [&](std::string_view line, std::string_view tag, std::string_view rest) {
    ++said.lines;
    if (tag == kG2oFix) {
      for (std::string_view word = take_word(rest); !word.empty() && word[0] != '#'; word = take_word(rest)) {
        said.fixed.push_back(id_in(word));
      }
    } else if (is_g2o_parameter(tag)) {
      said.parameters += line;
      if (!line.ends_with('\n')) said.parameters += '\n';
    } else if (!tag.empty() && tag[0] != '#') {
      part.has_graph = true;
      if (is_pose_vertex(tag)) part.declared_poses.push_back(id_in(take_word(rest)));
      if (is_feature_vertex(tag)) part.declared_features.push_back(id_in(take_word(rest)));
    }
  });
  return said;
}

}  // namespace

std::string TextPart::vertices_of(const std::vector<std::uint64_t>& poses) const {
  std::string vertices;
  for_each_line(text, [&](std::string_view line, std::string_view tag, std::string_view rest) {
    if (!is_pose_vertex(tag) || !std::ranges::binary_search(poses, id_in(take_word(rest)))) return;
    vertices += line;
    if (!line.ends_with('\n')) vertices += '\n';
  });
  return vertices;
}

Expected<TextPart> read_text_part(const Communicator& comm, const std::filesystem::path& path) {
  auto bytes = comm.agree(plain_g2o(path));
  if (!bytes) return tl::unexpected(bytes.error());
  TextPart part{*std::move(bytes), {}, 0, false, {}, {}, {}, {}, {}};
  part.text = range_of(part.bytes.view(), comm.rank(), comm.size());
  const SaidOfAll mine = scan(part);
  part.fixed = comm.gather(mine.fixed);
  if (!part.fixed.empty()) part.first_fixed = part.fixed.front();
  make_distinct(part.fixed);
  const std::vector<std::uint64_t> lines = comm.gather(std::vector{mine.lines});
  const std::vector<std::string> parameters = comm.gather(mine.parameters);
  for (std::size_t r = 0; r < lines.size(); ++r) {
    if (r < static_cast<std::size_t>(comm.rank())) part.lines_before += lines[r];
    if (r != static_cast<std::size_t>(comm.rank())) part.parameters += parameters[r];
  }
  return part;
}

}  // namespace mapjoin::distributed
