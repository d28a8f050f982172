// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A part of a g2o file.

#include <mapjoin/io/read_options.hpp>
#include <mapjoin/io/text_scanner.hpp>
#include <mapjoin/model/error.hpp>

namespace mapjoin {

/// As read_g2o(), of some lines of a file: what other lines say of an id is not missed, and FIX is passed over.
Expected<AnyLog> read_g2o_part(TextScanner text, const ReadOptions& options);

}  // namespace mapjoin
