// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <system_error>
#include <utility>

namespace mapjoin {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

bool ends_word(char c) {
  return c == '\n' || is_blank(c);
}

/// True if `number`, which is out of the range of doubles, is too small rather than too large.
bool is_tiny(std::string_view number) {
  const std::size_t e = std::min(number.find_first_of("eE"), number.size());
  const std::string_view digits = number.substr(0, e);
  const auto first_digit = static_cast<std::int64_t>(digits.find_first_of("123456789"));
  const auto point = static_cast<std::int64_t>(std::min(digits.find('.'), digits.size()));
  std::string_view power = number.substr(e);
  if (power.size() < 2) return point < first_digit;
  power.remove_prefix(power[1] == '+' ? 2 : 1);
  std::int64_t exponent = 0;
  const auto status = std::from_chars(power.data(), power.data() + power.size(), exponent).ec;
  return status == std::errc() ? exponent < first_digit - point : power.front() == '-';
}

/// Parses the number at the start of [begin, end): its end, or null if there is none. A number too small for a double is zero.
const char* parse_number(const char* begin, const char* end, double& value) {
  // Most numbers of information matrices are short integers, "0" above all.
  std::int64_t integer = 0;
  const char* digit = begin;
  for (; digit != end && digit - begin < 15 && *digit >= '0' && *digit <= '9'; ++digit) integer = 10 * integer + (*digit - '0');
  if (digit != begin && (digit == end || ends_word(*digit))) {
    value = static_cast<double>(integer);
    return digit;
  }
  const auto [rest, status] = std::from_chars(begin, end, value);
  if (status == std::errc::result_out_of_range) {
    value = 0.0;
    return is_tiny({begin, static_cast<std::size_t>(rest - begin)}) ? rest : nullptr;
  }
  return status == std::errc() && std::isfinite(value) ? rest : nullptr;
}

template <typename Integer>
const char* parse_number(const char* begin, const char* end, Integer& value) {
  const auto [rest, status] = std::from_chars(begin, end, value);
  return status == std::errc() ? rest : nullptr;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= ' ' && c <= '~' ? c : '?';
  return result;
}

std::string shortened(std::string_view word) {
  constexpr std::size_t kMost = 40;
  return printable(word.substr(0, kMost)) + (word.size() > kMost ? "..." : "");
}

std::string in_quotes(std::string_view word) {
  return "'" + shortened(word) + "'";
}

TextScanner::TextScanner(std::string source, std::string_view text, std::size_t lines_before)
    : source_(std::move(source)),
      next_(text.data()),
      end_(text.data() + text.size()),
      line_begin_(next_),
      word_(next_),
      lines_before_(lines_before) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (lines_before == 0 && text.substr(0, 3) == kByteOrderMark) next_ += kByteOrderMark.size();
}

std::vector<TextScanner> TextScanner::pieces(std::size_t bytes) const {
  std::vector<std::string_view> texts;
  for (std::string_view rest(next_, static_cast<std::size_t>(end_ - next_)); !rest.empty();) {
    const std::size_t newline = rest.size() > bytes ? rest.find('\n', bytes) : std::string_view::npos;
    const std::size_t size = newline == std::string_view::npos ? rest.size() : newline + 1;
    texts.push_back(rest.substr(0, size));
    rest.remove_prefix(size);
  }
  std::vector<std::size_t> lines(texts.size());
  parallel_for(texts.size(),
               [&](std::size_t k) { lines[k] = static_cast<std::size_t>(std::count(texts[k].begin(), texts[k].end(), '\n')); });
  std::vector<TextScanner> pieces;
  std::size_t lines_before = lines_before_;
  for (std::size_t k = 0; k < texts.size(); ++k) {
    pieces.emplace_back(source_, texts[k], lines_before);
    lines_before += lines[k];
  }
  return pieces;
}

bool TextScanner::next_line() {
  failure_.clear();
  while (next_ != end_) {
    if (line_ > 0) {
      const void* const newline = std::memchr(next_, '\n', static_cast<std::size_t>(end_ - next_));
      next_ = newline ? static_cast<const char*>(newline) + 1 : end_;
    }
    ++line_;
    line_begin_ = next_;
    const bool has_word = next_ != end_ && !at_end_of_line();
    word_ = next_;
    if (has_word) return true;
  }
  return false;
}

bool TextScanner::at_end_of_line() {
  if (!failure_.empty()) return true;
  while (next_ != end_ && is_blank(*next_)) ++next_;
  return next_ == end_ || *next_ == '\n' || *next_ == '#';
}

std::string_view TextScanner::word() {
  const bool none = at_end_of_line();
  word_ = next_;
  if (none) return {};
  while (next_ != end_ && !ends_word(*next_)) ++next_;
  return {word_, static_cast<std::size_t>(next_ - word_)};
}

void TextScanner::reject(std::string_view message) {
  if (failure_.empty()) failure_ = error(message).value().message;
}

void TextScanner::reject_next(std::string_view expected) {
  const std::string_view next = word();
  reject(fmt::format("{} where {} is expected", next.empty() ? "the line ends" : in_quotes(next) + " stands", expected));
}

template <typename Number>
Number TextScanner::parse(std::string_view expected) {
  if (!failure_.empty()) return {};
  Number value{};
  const char* rest = nullptr;
  if (!at_end_of_line()) {
    const bool has_plus = *next_ == '+' && next_ + 1 != end_ && next_[1] != '-';
    rest = parse_number(next_ + (has_plus ? 1 : 0), end_, value);
  }
  if (!rest || (rest != end_ && !ends_word(*rest))) {
    reject_next(expected);
    return {};
  }
  word_ = std::exchange(next_, rest);
  return value;
}

double TextScanner::number() {
  return parse<double>("a number");
}

std::uint64_t TextScanner::key() {
  const bool may_be_symbol =
      !at_end_of_line() && symbol_letter(std::uint64_t{static_cast<unsigned char>(*next_)} << 56) != '\0';
  const char* const begin = next_;
  if (const auto symbol = may_be_symbol ? parse_key(word()) : std::nullopt) return *symbol;
  next_ = begin;
  return parse<std::uint64_t>("an id");
}

std::int64_t TextScanner::integer() {
  return parse<std::int64_t>("an integer");
}

Expected<void> TextScanner::finish_line() {
  if (!failure_.empty()) return bad_input(failure_);
  if (at_end_of_line()) return {};
  const std::string_view extra = word();
  return error(fmt::format("{} stands where the line should end", in_quotes(extra)));
}

tl::unexpected<Error> TextScanner::error(const Place& place, std::string_view message) const {
  return bad_input(fmt::format("{}:{}:{}: {}", source_, place.line, place.column, message));
}

}  // namespace mapjoin
