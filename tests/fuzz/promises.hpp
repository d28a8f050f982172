// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What every reader promises of any bytes, beyond not to crash.

#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <string_view>

namespace mapjoin::fuzz {

/// Throws std::logic_error where it is not kept.
void promise(bool kept, std::string_view what);

/// An error is one line that a terminal takes as text, and begins with the file, or with its folder.
void check_error(const Error& error, const std::string& file);

/// The same log or the same maps have the same bits.
std::string bits_of(const AnyLog& log);
std::string bits_of(const AnySubmapSet& set);

/// Everything is finite, and as Log promises.
void check_log(const AnyLog& log);
/// Indices, sizes and information matrices of the maps are right.
void check_maps(const AnySubmapSet& set);

/// What was read, or why not, is as it should be.
void check(const Expected<AnyLog>& log, const std::string& file);
void check(const Expected<AnySubmapSet>& set, const std::string& file);

/// A log that the format can be written in reads back; with the same bits, where nothing is said to be lost.
void check_round_trip(const AnyLog& log, LogFormat format);

}  // namespace mapjoin::fuzz
