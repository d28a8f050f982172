// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One map of a log some of whose measurements are wrong: its start, and what counts in it.

#include <mapjoin/join/robust/truncated_join.hpp>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <stop_token>
#include <string>

namespace mapjoin {

/// How far from its prediction a measurement may be (squared Mahalanobis distance) and still count.
struct Gates {
  OfKinds widest;               ///< What the confidence allows.
  OfKinds scale{1.0, 1.0};      ///< How closely what is right fits, as a share of that; see scale_of().
  std::optional<OfKinds> last;  ///< In place of the narrow ones, where all are tried again.

  OfKinds narrow() const { return {scale.closures * widest.closures, scale.observations * widest.observations}; }
  OfKinds now() const { return last.value_or(narrow()); }
};

/// A first estimate of a log, by a join; its errors are those of run(), but that edges may leave directions free.
template <int Dim>
Expected<Values<Dim>> started_map(Log<Dim> log, Engine engine, const std::stop_token& stop);

/// Brings a join to where all that counts passes its tests. Observations that do not count and pass theirs are let in again at
/// the first estimate, and once more when nothing is left to drop; with `gates.last` closures are this second time, too. Finds
/// the scale of `gates`. Bad input, which names `source`, where what counts leaves something free to move; kInterrupted on
/// `stop`.
template <int Dim>
Expected<void> settle(TruncatedJoin<Dim>& join, Gates& gates, const std::string& source, const std::stop_token& stop);

}  // namespace mapjoin
