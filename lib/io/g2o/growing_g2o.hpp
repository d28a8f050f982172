// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A g2o file that another program is still writing: the lines appended to it, as soon as they are whole.

#include <filesystem>
#include <mapjoin/io/files/system_call.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string>

namespace mapjoin {

class GrowingG2o {
 public:
  /// Opens a file to be followed; bad input if it is not a plain file. Gzip is refused when it is read.
  static Expected<GrowingG2o> open(const std::filesystem::path& path, const ReadOptions& options);

  /// The edges, observations and priors in the lines that have come since the last call, as a log of their own; nullopt if none
  /// of them names a pose: they are given with the next that does. Bad input, with the line, if one is wrong: the lines before
  /// it were given by the call before, and no more are given. Bad input, too, if the file was cut, or if its name belongs to
  /// another file or to none: its content was given by the call before.
  Expected<std::optional<AnyLog>> appended();
  /// The log of the lines not yet given, as appended(), including a last line without an end; for when no more is to come.
  Expected<std::optional<AnyLog>> rest();
  /// The number of bytes read so far; the last of them may be half a line.
  std::size_t size() const { return text_.size(); }

  /// The log of all lines given so far, as read_g2o() reads it.
  Expected<AnyLog> whole() const { return whole(options_.undeclared); }
  /// The same where more may come: edges to what no line declares yet are taken, as appended() takes them, and vertices that no
  /// edge names yet are left out.
  Expected<AnyLog> so_far() const { return whole(Undeclared::kToCome); }

 private:
  GrowingG2o(std::filesystem::path path, const ReadOptions& options);
  Expected<AnyLog> whole(Undeclared undeclared) const;
  Expected<void> read_on();
  Expected<std::optional<AnyLog>> take_until(std::size_t end);
  /// The log in bytes [taken_, end).
  Expected<AnyLog> log_until(std::size_t end) const;
  bool has_edges_until(std::size_t end) const;
  std::size_t good_until(std::size_t end) const;

  std::filesystem::path path_;
  ReadOptions options_;
  Descriptor descriptor_;
  std::string text_;        // Content of the file so far.
  std::size_t taken_ = 0;   // Bytes of `text_` that were given.
  std::string parameters_;  // Lines of the given bytes, empty but for parameters that later observations may name.
  std::optional<Error> fault_;
};

}  // namespace mapjoin
