// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a check found: one sentence, how often, and where.

#include <cstddef>
#include <mapjoin/model/counted.hpp>
#include <mapjoin/model/enum_names.hpp>
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

/// How often something was found, and the names of the first places.
struct Places {
  static constexpr std::size_t kMost = 20;

  /// One more; `name()` gives its name where it is kept.
  template <typename Name>
  void add(const Name& name) {
    if (++count <= kMost) names.push_back(name());
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

}  // namespace mapjoin
