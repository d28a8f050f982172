// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What went wrong, in one sentence for the user, and of which kind, for the exit code.

#include <concepts>
#include <stdexcept>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace mapjoin {

enum class ErrorKind {
  kBadInput,     ///< The data cannot be used as they are.
  kUsage,        ///< The options contradict each other or the data.
  kCannotWrite,  ///< An output could not be written; nothing half-written is left.
  kTooLarge,     ///< Refused before memory was asked for.
  kInterrupted,  ///< Cancelled through the stop token.
};

/// One clear sentence; for a file it begins with `file:line:column: `, or names variable and row.
struct Error {
  ErrorKind kind = ErrorKind::kBadInput;
  std::string message;
};

template <typename T>
using Expected = tl::expected<T, Error>;

inline tl::unexpected<Error> bad_input(std::string message) {
  return tl::unexpected(Error{ErrorKind::kBadInput, std::move(message)});
}

/// The same of data that came from `source`, where that has a name.
inline tl::unexpected<Error> bad_input_of(const std::string& source, const std::string& message) {
  return bad_input(source.empty() ? message : source + ": " + message);
}

/// Of work that a stop has ended; `doing` says what.
inline tl::unexpected<Error> interrupted(const std::string& doing = "") {
  return tl::unexpected(Error{ErrorKind::kInterrupted, doing.empty() ? "interrupted" : "interrupted while " + doing});
}

/// Throws std::invalid_argument with the first violation of `options`, where there is one: a promise broken by the caller.
template <typename Options>
void demand_valid(const Options& options) {
  const auto violations = options.validate();
  if (!violations.empty()) throw std::invalid_argument(violations.front());
}

/// "1 edge", "2 edges"; "2 matrices" where `things` are not `thing` and an s.
template <std::integral Count>
std::string plural(Count count, const std::string& thing, const std::string& things = "") {
  return std::to_string(count) + " " + (count == 1 ? thing : things.empty() ? thing + "s" : things);
}

}  // namespace mapjoin
