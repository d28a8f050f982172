// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Exit codes. A command returns one or, if it cannot go on, throws an Error: by fail(), by demand(), or by `.value()` of an
// Expected without a value.

#include <algorithm>
#include <array>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace mapjoin::apps {

enum class ExitCode : int {
  kDone = 0,
  kInternalError = 1,
  kFindings = 1,  ///< Findings of `check`, as of linters; an internal error is told on standard error.
  kUsage = 2,
  kBadInput = 3,
  kDidNotConverge = 4,  ///< The result was written, and says so.
  kCannotWrite = 5,
  kTooLarge = 6,
  kDoesNotFit = 7,  ///< With --strict. The result was written.
  kInterrupted = 130,
};

struct ExitCodeMeaning {
  ExitCode code;
  std::string_view text;  ///< Meaning in the help and the manual.
  std::optional<ErrorKind> kind = std::nullopt;
};
inline constexpr std::array kExitCodes = {
    ExitCodeMeaning{ExitCode::kDone, "done"},
    ExitCodeMeaning{ExitCode::kInternalError, "internal error (of check: there are findings)"},
    ExitCodeMeaning{ExitCode::kUsage, "usage", ErrorKind::kUsage},
    ExitCodeMeaning{ExitCode::kBadInput, "bad input", ErrorKind::kBadInput},
    ExitCodeMeaning{ExitCode::kDidNotConverge, "did not converge (the result is written)"},
    ExitCodeMeaning{ExitCode::kCannotWrite, "cannot write", ErrorKind::kCannotWrite},
    ExitCodeMeaning{ExitCode::kTooLarge, "too large", ErrorKind::kTooLarge},
    ExitCodeMeaning{ExitCode::kDoesNotFit, "does not fit, or nothing tells (with --strict; the result is written)"},
    ExitCodeMeaning{ExitCode::kInterrupted, "interrupted", ErrorKind::kInterrupted},
};

inline ExitCode exit_code_of(ErrorKind kind) {
  return std::find_if(kExitCodes.begin(), kExitCodes.end(), [&](const auto& meaning) { return meaning.kind == kind; })->code;
}

[[noreturn]] inline void fail(ErrorKind kind, std::string sentence) {
  throw tl::bad_expected_access<Error>(Error{kind, std::move(sentence)});
}
inline void demand(const Expected<void>& done) {
  if (!done) fail(done.error().kind, done.error().message);
}

}  // namespace mapjoin::apps
