// SPDX-License-Identifier: BSD-3-Clause
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/g2o/growing_g2o.hpp>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// True if a line has an edge, an observation or a prior that is not left out as unknown.
bool has_edges(std::string_view text, const ReadOptions& options) {
  for (TextScanner ahead("", text); ahead.next_line();) {
    const std::string_view tag = ahead.word();
    if (tag.starts_with("EDGE_") && (!options.skip_unknown || is_g2o_tag(tag))) return true;
  }
  return false;
}

bool has_poses(const AnyLog& any) {
  return std::visit([](const auto& log) { return !log.poses.empty(); }, any);
}

/// The text with every line emptied but those of parameters.
std::string parameters_in(std::string_view text) {
  std::string lines;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, std::min(text.find('\n'), text.size() - 1) + 1);
    TextScanner scanner("", line);
    lines += scanner.next_line() && is_g2o_parameter(scanner.word()) ? line : "\n";
    text.remove_prefix(line.size());
  }
  return lines;
}

}  // namespace

Expected<GrowingG2o> GrowingG2o::open(const std::filesystem::path& path, const ReadOptions& options) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return call_failed(path, errno, ErrorKind::kBadInput);
  // Opening a pipe would wait for its writer.
  if (!S_ISREG(status.st_mode)) return bad_input(path.string() + ": only a plain file can be followed");
  GrowingG2o file(path, options);
  if (!file.descriptor_.is_open()) return call_failed(path, errno, ErrorKind::kBadInput);
  return file;
}

GrowingG2o::GrowingG2o(std::filesystem::path path, const ReadOptions& options)
    : path_(std::move(path)), options_(options), descriptor_(Descriptor::to_read(path_)) {}

Expected<void> GrowingG2o::read_on() {
  struct stat status {};
  if (::fstat(descriptor_.value(), &status) != 0) return call_failed(path_, errno, ErrorKind::kBadInput);
  if (static_cast<std::size_t>(status.st_size) < text_.size()) {
    return bad_input(path_.string() + ": the file was cut while it was followed");
  }
  std::array<char, 1 << 16> bytes;
  while (true) {
    const ::ssize_t read = ::pread(descriptor_.value(), bytes.data(), bytes.size(), static_cast<::off_t>(text_.size()));
    if (read < 0) return call_failed(path_, errno, ErrorKind::kBadInput);
    if (read == 0) break;
    text_.append(bytes.data(), static_cast<std::size_t>(read));
  }
  if (std::string_view(text_).substr(0, 2) == "\x1f\x8b")
    return bad_input(path_.string() + ": only plain text can be followed, not gzip");
  return {};
}

Expected<std::optional<AnyLog>> GrowingG2o::appended() {
  if (fault_) return tl::unexpected(*fault_);
  if (auto read = read_on(); !read) return tl::unexpected(read.error());
  auto news = take_until(text_.rfind('\n') + 1);
  if (!fault_ && !has_name(descriptor_.value(), path_)) {
    fault_ = Error{ErrorKind::kBadInput,
                   path_.string() + ": the file was replaced, renamed or removed while it was followed; follow it anew"};
  }
  return news;
}

Expected<std::optional<AnyLog>> GrowingG2o::rest() {
  if (fault_) return tl::unexpected(*fault_);
  auto news = take_until(text_.size());
  if (!news || *news || taken_ == text_.size()) return news;
  // Lines without such an edge have waited for one: the whole file is checked with them.
  if (const auto all = read_g2o(TextScanner(path_.string(), text_), options_); !all) {
    fault_ = all.error();
    return tl::unexpected(*fault_);
  }
  taken_ = text_.size();
  return news;
}

/// Takes the lines before `end`; lines without an edge that names a pose wait for one.
Expected<std::optional<AnyLog>> GrowingG2o::take_until(std::size_t end) {
  if (end <= taken_ || !has_edges_until(end)) return std::nullopt;
  auto log = log_until(end);
  if (!log) {
    const std::size_t good = good_until(end);
    if (good == taken_) return tl::unexpected(log.error());
    fault_ = log.error();
    end = good;
    log = log_until(end);
  }
  if (!has_poses(*log)) return std::nullopt;
  parameters_ += parameters_in(std::string_view(text_).substr(taken_, end - taken_));
  taken_ = end;
  return std::optional<AnyLog>(*std::move(log));
}

Expected<AnyLog> GrowingG2o::log_until(std::size_t end) const {
  const std::string lines = parameters_ + text_.substr(taken_, end - taken_);
  return read_g2o(TextScanner(path_.string(), lines), options_, {.is_whole = false, .needs_poses = false});
}

bool GrowingG2o::has_edges_until(std::size_t end) const {
  return has_edges(std::string_view(text_).substr(taken_, end - taken_), options_);
}

/// The end of the last line up to which all lines are right and one has an edge; otherwise `taken_`, where the last call ended.
std::size_t GrowingG2o::good_until(std::size_t end) const {
  std::vector<std::size_t> ends;
  for (std::size_t next = text_.find('\n', taken_); next < end; next = text_.find('\n', next + 1)) ends.push_back(next + 1);
  const auto is_wrong = [&](std::size_t line_end) { return has_edges_until(line_end) && !log_until(line_end); };
  const auto first_wrong = std::partition_point(ends.begin(), ends.end(), [&](std::size_t e) { return !is_wrong(e); });
  if (first_wrong == ends.begin()) return taken_;
  const std::size_t good = *(first_wrong - 1);
  return has_edges_until(good) ? good : taken_;
}

Expected<AnyLog> GrowingG2o::whole(Undeclared undeclared) const {
  ReadOptions options = options_;
  options.undeclared = undeclared;
  return read_g2o(TextScanner(path_.string(), std::string_view(text_).substr(0, taken_)), options);
}

}  // namespace mapjoin
