// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the command tells the shell.

#include <array>
#include <mapjoin/model/error.hpp>
#include <string_view>
#include <utility>

namespace mapjoin::apps {

enum class ExitCode : int {
  kDone = 0,
  kInternalError = 1,
  kFindings = 1,  ///< Of `check`, as of its like elsewhere; an internal error is told on standard error.
  kUsage = 2,
  kBadInput = 3,
  kDidNotConverge = 4,  ///< The result was written, and says so.
  kCannotWrite = 5,
  kTooLarge = 6,
  kInterrupted = 130,
};

/// What the help and the manual say of them.
inline constexpr std::array<std::pair<ExitCode, std::string_view>, 8> kExitCodes = {{
    {ExitCode::kDone, "done"},
    {ExitCode::kInternalError, "internal error (of check: there are findings)"},
    {ExitCode::kUsage, "usage"},
    {ExitCode::kBadInput, "bad input"},
    {ExitCode::kDidNotConverge, "did not converge (the result is written)"},
    {ExitCode::kCannotWrite, "cannot write"},
    {ExitCode::kTooLarge, "too large"},
    {ExitCode::kInterrupted, "interrupted"},
}};

inline ExitCode exit_code_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kBadInput:
      return ExitCode::kBadInput;
    case ErrorKind::kUsage:
      return ExitCode::kUsage;
    case ErrorKind::kCannotWrite:
      return ExitCode::kCannotWrite;
    case ErrorKind::kTooLarge:
      return ExitCode::kTooLarge;
    case ErrorKind::kInterrupted:
      return ExitCode::kInterrupted;
  }
  return ExitCode::kInternalError;
}

}  // namespace mapjoin::apps
