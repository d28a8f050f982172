// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A g2o file that another program is still writing: what has been appended, line by whole line.

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
  /// Bad input where the file is not a plain file; gzip is refused, too.
  static Expected<GrowingG2o> open(const std::filesystem::path& path, const ReadOptions& options);

  /// The edges and observations in the lines that have come since the last call, as a log of their own; nothing where none
  /// have. Bad input, with the line, where one is wrong: what stands before it was given by the call before, and nothing
  /// comes any more. Bad input, too, where the file was cut, or where its name is another file's or none's: what was in it
  /// was given by the call before.
  Expected<std::optional<AnyLog>> appended();
  /// The same with a last line that has no end yet; there is no more to come.
  Expected<std::optional<AnyLog>> rest();
  /// How many bytes are in the file, of which those at the end may be half a line.
  std::size_t size() const { return text_.size(); }

  /// The log of all lines given so far, as read_g2o() reads it.
  Expected<AnyLog> whole() const;

 private:
  GrowingG2o(std::filesystem::path path, const ReadOptions& options);
  Expected<void> read_on();
  Expected<std::optional<AnyLog>> take_until(std::size_t end);
  /// The log in bytes [taken_, end).
  Expected<AnyLog> log_until(std::size_t end) const;
  std::size_t good_until(std::size_t end) const;

  std::filesystem::path path_;
  ReadOptions options_;
  Descriptor descriptor_;
  std::string text_;        // of the file so far
  std::size_t taken_ = 0;   // bytes of it that were given
  std::string parameters_;  // the lines of these, empty but for what later observations may name
  std::optional<Error> fault_;
};

}  // namespace mapjoin
