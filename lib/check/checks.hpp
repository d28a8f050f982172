// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Findings of checks: one sentence, a count, and places. Checks of a log or a set of maps that need no estimate: structure,
// units and repetitions.

#include <cstddef>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin {

enum class FindingLevel {
  kNote,     ///< Worth knowing; nothing is wrong.
  kWarning,  ///< Probably not intended, or resting on one measurement that nothing confirms.
  kError,    ///< No map can be made of this.
};

constexpr auto enum_names(FindingLevel) {
  return std::to_array<EnumName<FindingLevel>>(
      {{FindingLevel::kNote, "note"}, {FindingLevel::kWarning, "warning"}, {FindingLevel::kError, "error"}});
}

/// The count of a finding, and the names of the places if they have any.
struct Places {
  void add(std::string name) {
    ++count;
    names.push_back(std::move(name));
  }

  std::size_t count = 0;
  std::vector<std::string> names;
};

struct Finding {
  FindingLevel level = FindingLevel::kNote;
  std::string check;  ///< Name of the check in a word: "weak_link".
  std::string text;   ///< A sentence without its full stop.
  Places where;
};

using Findings = std::vector<Finding>;

/// Adds a finding that has at least one place.
inline void add_if_any(Findings& findings, Finding finding) {
  if (finding.where.count > 0) findings.push_back(std::move(finding));
}

/// The number of odometry steps, and of those among them with several edges.
struct StepCounts {
  std::size_t all = 0;
  std::size_t repeated = 0;
  /// The number of repeated steps if these are most of all and at least ten, as when two logs are written into one file;
  /// otherwise 0.
  std::size_t driven_twice() const;
};
template <int Dim>
StepCounts count_steps(const Log<Dim>& log);

/// The message on so many steps with several edges, with advice.
std::string repeated_steps_in_words(std::size_t steps);

/// Checks the structure of a log or a set of maps:
/// - `unsound` (error): the fault that check_invariants() finds in a log, whose other checks then find nothing.
/// - `unobserved` (error): features that are declared, but never observed.
/// - `parts` (error): several components that nothing ties together, or poses and no edges at all.
/// - `loose_body` (error), `weak_body` (warning): poses that only features tie to the others: fewer than Dim, which it takes to
///   hold them, or just as many.
/// - `weak_link`, `weak_feature` (warnings): see check/weak_links.hpp.
/// - `seen_once` (note; of a log a warning if it is most of them): features that add nothing to the map.
/// - `stamps` (warning): poses whose time is not later than that of the pose driven before.
/// - `breaks` (note): steps without odometry within one session of the user's.
/// - `unassociated` (note): observations left out by the reader.
/// - `driven_twice` (warning): see StepCounts.
template <int Dim>
Findings check_structure(const Log<Dim>& log);
template <int Dim>
Findings check_structure(const SubmapSet<Dim>& set);

/// Checks the units of headings in the plane. Finds nothing in space, where files give rotations that degrees would not pass
/// for, nor in a log that is `unsound` (see check_structure()).
/// - `degrees` (warning): relative headings beyond a full turn, more than one in a hundred; or loops of up to ten odometry
///   steps, closed by a closure or a feature seen again, that close far better with headings taken as degrees; or initial
///   headings that turn 57.3 times more, or less, than the edges; or odometry with a standard deviation of heading above a
///   quarter turn.
/// - `unwrapped` (note): relative headings between a half and a full turn, which are taken as they are.
template <int Dim>
Findings check_units(const Log<Dim>& log);

/// Checks edges between the same two poses, whatever their direction, and observations of one feature from one pose; compares
/// each with the one before it in the log. Finds nothing in a log that is `unsound` (see check_structure()). O(n log n).
/// - `copies` (warning): equal to the last digit, so that one measurement counts twice.
/// - `contradiction` (warning): differing by more than the covariances allow, except once in 10⁹ times.
/// - `repeated` (note): neither; all of them count.
template <int Dim>
Findings check_repeats(const Log<Dim>& log);

}  // namespace mapjoin
