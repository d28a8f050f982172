// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Errors as values: one sentence for the user, and a kind for the exit code.

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
  kTooLarge,     ///< Refused before memory is allocated.
  kInterrupted,  ///< Cancelled through the stop token.
};

/// A kind and one clear sentence, which begins with `file:line:column: ` for a file, or names variable and row.
struct Error {
  ErrorKind kind = ErrorKind::kBadInput;
  std::string message;
};

template <typename T>
using Expected = tl::expected<T, Error>;

inline tl::unexpected<Error> bad_input(std::string message) {
  return tl::unexpected(Error{ErrorKind::kBadInput, std::move(message)});
}

/// A kBadInput in data from `source`, which precedes the message unless it is empty.
inline tl::unexpected<Error> bad_input_of(const std::string& source, const std::string& message) {
  return bad_input(source.empty() ? message : source + ": " + message);
}

/// The error of work ended by a stop request; `doing` names the work.
inline tl::unexpected<Error> interrupted(const std::string& doing = "") {
  return tl::unexpected(Error{ErrorKind::kInterrupted, doing.empty() ? "interrupted" : "interrupted while " + doing});
}

/// Throws std::invalid_argument with the first violation of `options`, if any: a precondition broken by the caller.
template <typename Options>
void demand_valid(const Options& options) {
  const auto violations = options.validate();
  if (!violations.empty()) throw std::invalid_argument(violations.front());
}

/// Throws std::invalid_argument with the fault that a check has found, if any: a precondition broken by the caller.
inline void demand_sound(const Expected<void>& checked) {
  if (!checked) throw std::invalid_argument(checked.error().message);
}

/// A count with its noun, "1 edge" or "2 edges"; `things` is the plural if it is not `thing` and an s ("2 matrices").
template <std::integral Count>
std::string plural(Count count, const std::string& thing, const std::string& things = "") {
  return std::to_string(count) + " " + (count == 1 ? thing : things.empty() ? thing + "s" : things);
}

}  // namespace mapjoin
