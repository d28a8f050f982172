// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The words and numbers of a text file, line by line, with the place of each for messages.

#include <cstdint>
#include <mapjoin/geometry/upper_triangle.hpp>
#include <mapjoin/model/error.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin {

/// The start of a word; line and column count from 1, the column in bytes.
struct Place {
  std::size_t line = 0;
  std::size_t column = 0;
};

/// Words are separated by blanks; `#` at the start of a word starts a comment to the end of the line; lines end with LF or
/// CRLF, the last one also without. Numbers are decimal, whatever the locale. The first failure of a number sticks: what
/// follows gives zeros until finish_line() reports it, so that a line is parsed as if it were right. A value: a copy reads on
/// from the same place.
class TextScanner {
 public:
  /// `source` is the file's name for messages. `text` must outlive the scanner; `lines_before` lines of the file precede it.
  TextScanner(std::string source, std::string_view text, std::size_t lines_before = 0);
  /// The text of a scanner that has not begun, cut at ends of lines into pieces of at least `bytes`, the last one maybe
  /// smaller.
  std::vector<TextScanner> pieces(std::size_t bytes) const;

  /// Moves to the next line that has a word, past the rest of this one; false at the end of the file.
  bool next_line();
  /// Calls `read` on every line from here on, until one is wrong.
  template <typename Read>
  Expected<void> each_line(const Read& read) {
    Expected<void> line;
    while (line && next_line()) {
      read();
      line = finish_line();
    }
    return line;
  }
  /// True if the line has no further word, or if one went wrong, after which none counts.
  bool at_end_of_line();

  /// The next word of the line, empty at its end.
  std::string_view word();
  /// The next word as a finite number.
  double number();
  /// The next word as an id, an integer from 0 to 2⁶⁴ - 1.
  std::uint64_t key();
  /// The next word as an integer.
  std::int64_t integer();
  template <int Size>
  Vector<Size> vector() {
    Vector<Size> v;
    for (int i = 0; i < Size; ++i) v[i] = number();
    return v;
  }
  /// The upper triangle, row by row, of a symmetric matrix.
  template <int Size>
  Matrix<Size> symmetric() {
    return from_upper_triangle<Size>([&] { return number(); });
  }

  /// Lets finish_line() say `message` about the last word, unless something went wrong before.
  void reject(std::string_view message);
  /// Bad input if a word of this line went wrong, or else if the line has a word too many.
  Expected<void> finish_line();

  const std::string& source() const { return source_; }
  /// The text that is left, and its number of bytes.
  std::string_view left() const { return {next_, size()}; }
  std::size_t size() const { return static_cast<std::size_t>(end_ - next_); }
  /// The place where the last word began or, at the end of a line, where the next one would have begun.
  Place place() const { return {lines_before_ + line_, static_cast<std::size_t>(word_ - line_begin_) + 1}; }
  /// A bad-input error whose message begins with `file:line:column: `.
  tl::unexpected<Error> error(const Place& place, std::string_view message) const;
  /// A bad-input error at place(), with `file:line:column: ` in front.
  tl::unexpected<Error> error(std::string_view message) const { return error(place(), message); }

 private:
  void reject_next(std::string_view expected);
  template <typename Number>
  Number parse(std::string_view expected);

  std::string source_;
  const char* next_;        ///< The next byte to look at.
  const char* end_;         ///< End of the text.
  const char* line_begin_;  ///< Start of the current line.
  const char* word_;        ///< Start of the last word.
  std::size_t lines_before_;
  std::size_t line_ = 0;
  std::string failure_;  ///< The first failure of this line.
};

/// A stranger's text for a message, with `?` for bytes that would end the line or that a terminal would take as a command.
std::string printable(std::string_view text);
/// A word as printable() gives it, shortened.
std::string shortened(std::string_view word);
/// A shortened() word in quotes.
std::string in_quotes(std::string_view word);

}  // namespace mapjoin
