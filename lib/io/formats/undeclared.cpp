// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/formats/undeclared.hpp>
#include <mapjoin/io/g2o/fields.hpp>

namespace mapjoin {
namespace {

/// The first pose on the rest of a line that no vertex declares, as a feature neither; nullopt if none.
std::optional<std::string> undeclared_among(TextScanner& text, const Declared& declared) {
  while (!text.at_end_of_line()) {
    const std::uint64_t key = text.key();
    if (!declared.has_pose(key) && !declared.has_feature(key)) return to_string(PoseId{0, key});
  }
  return std::nullopt;
}

/// The pose or feature that a line of this tag names and no vertex declares; nullopt if none.
template <int Dim>
std::optional<std::string> undeclared_in(std::string_view tag, TextScanner& text, const EdgeText<Dim>& format,
                                         const Declared& declared) {
  if (format.has_g2o_lines && tag == kG2oFix) return undeclared_among(text, declared);
  const PriorTag* prior = format.prior(tag);
  const bool is_edge = tag == format.edge_tag;
  if (!is_edge && !prior && tag != format.observation_tag) return std::nullopt;
  const auto pose = [&](std::uint64_t key) {
    return declared.has_pose(key) ? std::nullopt : std::optional(to_string(PoseId{0, key}));
  };
  const auto feature = [&](std::uint64_t key) {
    return declared.has_feature(key) ? std::nullopt : std::optional(to_string(FeatureId{key}));
  };
  const std::uint64_t first = text.key();
  if (prior) return prior->kind == PriorTag::Kind::kFeature ? feature(first) : pose(first);
  const std::uint64_t second = text.key();
  if (auto missing = pose(first)) return missing;
  return is_edge ? pose(second) : feature(second);
}

}  // namespace

template <int Dim>
std::optional<UndeclaredName> first_undeclared(TextScanner text, const EdgeText<Dim>& format, const Declared& declared,
                                               bool with_edges) {
  while (text.next_line()) {
    const std::string_view tag = text.word();
    const Place place = text.place();
    if (!with_edges && tag == format.edge_tag) continue;
    if (auto name = undeclared_in(tag, text, format, declared)) return UndeclaredName{place, *std::move(name)};
  }
  return std::nullopt;
}

template <int Dim>
std::set<std::uint64_t> not_named_as_poses(TextScanner text, const EdgeText<Dim>& format, std::set<std::uint64_t> keys) {
  while (!keys.empty() && text.next_line()) {
    const std::string_view tag = text.word();
    const PriorTag* prior = format.prior(tag);
    const bool is_edge = tag == format.edge_tag;
    const bool is_of_pose = is_edge || tag == format.observation_tag || (prior && prior->kind != PriorTag::Kind::kFeature);
    if (!is_of_pose) continue;
    const std::uint64_t first = text.key();
    const std::uint64_t second = is_edge ? text.key() : first;
    if (is_edge && first == second) continue;  // which may be left out
    keys.erase(first);
    keys.erase(second);
  }
  return keys;
}

std::vector<FixedName> fixed_names(TextScanner text) {
  std::vector<FixedName> names;
  while (text.next_line()) {
    if (text.word() != kG2oFix) continue;
    while (!text.at_end_of_line()) {
      const std::uint64_t key = text.key();
      names.push_back({key, text.place()});
    }
  }
  return names;
}

template std::optional<UndeclaredName> first_undeclared(TextScanner, const EdgeText<2>&, const Declared&, bool);
template std::optional<UndeclaredName> first_undeclared(TextScanner, const EdgeText<3>&, const Declared&, bool);
template std::set<std::uint64_t> not_named_as_poses(TextScanner, const EdgeText<2>&, std::set<std::uint64_t>);
template std::set<std::uint64_t> not_named_as_poses(TextScanner, const EdgeText<3>&, std::set<std::uint64_t>);

}  // namespace mapjoin
