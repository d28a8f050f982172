// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The promises that every reader keeps on any bytes, beyond not to crash.

#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <string_view>

namespace mapjoin::fuzz {

/// Throws std::logic_error unless the promise is kept.
void promise(bool kept, std::string_view what);

/// Checks that an error is one line of printable text, and begins with the file or its folder.
void check_error(const Error& error, const std::string& file);

/// The names and numbers of a log or of maps as bytes, to compare them bit by bit.
std::string bits_of(const AnyLog& log);
std::string bits_of(const AnySubmapSet& set);

/// Checks that everything is finite, and as Log promises.
void check_log(const AnyLog& log);
/// Checks indices, sizes and information matrices of maps.
void check_maps(const AnySubmapSet& set);

/// Checks what was read, or the error.
void check(const Expected<AnyLog>& log, const std::string& file);
void check(const Expected<AnySubmapSet>& set, const std::string& file);

/// Checks that a log that the format can hold reads back when written: with the same bits if losses() names none.
void check_round_trip(const AnyLog& log, LogFormat format);

}  // namespace mapjoin::fuzz
