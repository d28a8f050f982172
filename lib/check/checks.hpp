// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a check finds: one sentence, how often, and where. Checks of a log or a set of maps that need no estimate: what ties it
// together, its units, and what it says more than once.

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
  kWarning,  ///< Probably not what was meant, or resting on one thing that nothing confirms.
  kError,    ///< There is no map of this.
};

constexpr auto enum_names(FindingLevel) {
  return std::to_array<EnumName<FindingLevel>>(
      {{FindingLevel::kNote, "note"}, {FindingLevel::kWarning, "warning"}, {FindingLevel::kError, "error"}});
}

/// How often something was found, and the names of the places, where these have any.
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
  std::string check;  ///< Which one, in a word: "weak_link".
  std::string text;   ///< A sentence without its end.
  Places where;
};

using Findings = std::vector<Finding>;

/// Where it was found anywhere.
inline void add_if_any(Findings& findings, Finding finding) {
  if (finding.where.count > 0) findings.push_back(std::move(finding));
}

/// How many steps of odometry there are, and how many of them have several edges.
struct StepCounts {
  std::size_t all = 0;
  std::size_t repeated = 0;
  /// How many have, where most have: as when two logs were written into one file; else 0.
  std::size_t driven_twice() const;
};
template <int Dim>
StepCounts count_steps(const Log<Dim>& log);

/// What to say of so many that have several edges, and how to go on.
std::string repeated_steps_in_words(std::size_t steps);

/// - `unobserved` (error): features that are declared, but never observed.
/// - `parts` (error): several components that nothing ties together.
/// - `loose_body` (error), `weak_body` (warning): poses that are tied to the others by features only, by fewer than it takes to
///   hold them, Dim, or by just as many.
/// - `weak_link`, `weak_feature` (warnings): see check/weak_links.hpp.
/// - `seen_once` (note; of a log a warning where it is most of them): features that add nothing to the map.
/// - `stamps` (warning): poses whose time is not later than that of the pose driven before.
/// - `breaks` (note): steps without odometry within one session of the user's.
/// - `unassociated` (note): observations left out by the reader.
/// - `driven_twice` (warning): see StepCounts.
template <int Dim>
Findings check_structure(const Log<Dim>& log);
template <int Dim>
Findings check_structure(const SubmapSet<Dim>& set);

/// In the plane; in space nothing, for files give rotations there that degrees would not pass for.
/// - `degrees` (warning): relative headings beyond a full turn, more than one in a hundred; or loops of up to ten steps, of
///   odometry and what was seen before and after it, that close far better with headings taken as degrees; or headings of the
///   file's values that turn 57.3 times more, or less, than its edges; or odometry whose heading is uncertain by more than a
///   quarter turn.
/// - `unwrapped` (note): relative headings between a half and a full turn, which are taken as they are.
template <int Dim>
Findings check_units(const Log<Dim>& log);

/// Of edges between the same two poses, whatever their direction, and of observations of one feature from one pose:
/// - `copies` (warning): they are alike to the last digit, so that what was measured once counts twice;
/// - `contradiction` (warning): they differ by more than their covariances allow but once in 10⁹ times;
/// - `repeated` (note): neither; all of them count.
/// Each is compared with the one before it in the log. O(n log n).
template <int Dim>
Findings check_repeats(const Log<Dim>& log);

}  // namespace mapjoin
