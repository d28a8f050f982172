// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Some lines of a text of edges, each read by itself; their reader puts them together.

#include <mapjoin/io/formats/declared_ids.hpp>
#include <mapjoin/io/formats/edge_text.hpp>
#include <mapjoin/model/log_builder.hpp>

namespace mapjoin {

inline constexpr const char* kSkipUnknown = "; --skip-unknown leaves such lines out";

template <int Dim>
struct EdgeTextPiece {
  LogBuilder<Dim> builder;
  DeclaredIds poses;
  DeclaredIds features;
  std::optional<Error> fault;  ///< The fault of the line behind these.
};

/// Reads `piece` up to its first wrong line.
template <int Dim>
EdgeTextPiece<Dim> read_edge_text_piece(TextScanner piece, const EdgeText<Dim>& format, const TextContext& context);

}  // namespace mapjoin
