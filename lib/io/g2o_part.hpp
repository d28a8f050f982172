// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A g2o file in parts.

#include <cstddef>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/io/text_scanner.hpp>
#include <mapjoin/model/error.hpp>

namespace mapjoin {

/// As read_g2o(), of some lines of a file: what other lines say of an id is not missed, and FIX is passed over.
Expected<AnyLog> read_g2o_part(TextScanner text, const ReadOptions& options);

/// As read_g2o(), which reads pieces of `piece_bytes` or little more side by side: the log does not depend on their size.
Expected<AnyLog> read_g2o_in_pieces(TextScanner text, const ReadOptions& options, std::size_t piece_bytes);

}  // namespace mapjoin
