// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <apps/names.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin::apps {
namespace {

constexpr std::string_view kPose = "pose:";
constexpr std::string_view kFeature = "feature:";

/// The parts of a word: a key and, as far as given, the session and the kind that it names.
struct Name {
  std::optional<std::uint64_t> key;
  std::optional<std::uint64_t> session;
  bool may_be_pose = true;
  bool may_be_feature = true;
};

Name parse(std::string_view word) {
  Name name;
  if (word.starts_with(kPose)) {
    name.may_be_feature = false;
    word.remove_prefix(kPose.size());
  } else if (word.starts_with(kFeature)) {
    name.may_be_pose = false;
    word.remove_prefix(kFeature.size());
  }
  if (const std::size_t colon = word.find(':'); name.may_be_pose && colon != std::string_view::npos) {
    name.may_be_feature = false;
    name.session = parse_key(word.substr(0, colon));
    if (!name.session) return name;
    word.remove_prefix(colon + 1);
  }
  name.key = parse_key(word);
  return name;
}

}  // namespace

Expected<PoseOrFeature> find_named(std::string_view word, const PoseIds& poses, const FeatureIds& features) {
  const auto wrong = [&](std::string why) {
    return tl::unexpected(Error{ErrorKind::kUsage, fmt::format("\"{}\" {}", word, why)});
  };
  const Name name = parse(word);
  if (!name.key) return wrong("names no pose and no feature: 17, a17, 1:17 (of session 1), pose:17 and feature:17 do");
  std::vector<PoseOrFeature> meant;
  std::vector<std::string> words;  // names that tell them apart
  for (const PoseIndex p : indices(poses)) {
    if (!name.may_be_pose || poses[p].key != *name.key || (name.session && poses[p].session != *name.session)) continue;
    meant.emplace_back(p);
    words.push_back(fmt::format("pose:{}:{}", poses[p].session, key_text(*name.key)));
  }
  if (const auto found = find_ascending(features, FeatureId{*name.key}); found && name.may_be_feature) {
    meant.emplace_back(FeatureIndex(*found));
    words.push_back(fmt::format("feature:{}", key_text(*name.key)));
  }
  if (meant.empty()) return wrong("is none of the poses and features; `mapjoin info` says which there are");
  if (meant.size() > 1) return wrong(fmt::format("could be {}", fmt::join(words, " or ")));
  return meant.front();
}

}  // namespace mapjoin::apps
