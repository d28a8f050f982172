// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <utility>

namespace mapjoin {

template <int Dim>
void LogBuilder<Dim>::forget_loose() {
  std::vector<PoseId> poses;
  std::vector<FeatureId> features;
  const auto note_ends = [&](const auto& kind, auto& targets) {
    for (std::size_t i = 0; i < kind.factors.size(); ++i) {
      if (kind.factors[i].base != kWorld) poses.push_back(kind.ends[i].first);
      targets.push_back(kind.ends[i].second);
    }
  };
  note_ends(poses_, poses);
  note_ends(features_, features);
  const auto keep = [](auto& names, auto& ids) {
    make_distinct(ids);
    names = {};
    for (const auto& id : ids) names.mention(id);
  };
  keep(poses_.names, poses);
  keep(features_.names, features);
  const auto forget = [](auto& said, const auto& ids) {
    std::erase_if(said, [&](const auto& of) { return !std::ranges::binary_search(ids, of.id); });
  };
  forget(poses_.initial, poses);
  forget(features_.initial, features);
  forget(stamps_, poses);
  forget(fixed_, poses);
  std::vector<PoseId> with_value;
  for (const auto& said : poses_.initial) with_value.push_back(said.id);
  make_distinct(with_value);
  bool is_first = true;
  std::erase_if(fixed_, [&](const auto& fixed) {
    const bool has_value = fixed.value || std::ranges::binary_search(with_value, fixed.id);
    return !has_value && !std::exchange(is_first, false);
  });
}

template void LogBuilder<2>::forget_loose();
template void LogBuilder<3>::forget_loose();

}  // namespace mapjoin
