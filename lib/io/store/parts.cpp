// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/io/store/contents.hpp>

namespace mapjoin {

Expected<void> check_complete(std::vector<Portion> portions, const std::string& source) {
  std::ranges::sort(portions, {}, &Portion::index);
  const std::size_t count = portions.front().count;
  bool are_complete = portions.size() == count;
  for (std::size_t k = 0; k < portions.size(); ++k) are_complete &= portions[k] == Portion{k, count};
  if (are_complete) return {};
  return bad_input(fmt::format("{}: its {} portions are to be joined together, each once; there are {}", source, count,
                               plural(portions.size(), "store")));
}

Expected<void> check_cut_alike(const std::vector<Segment>& one, const std::vector<Segment>& other, const std::string& source) {
  const auto is_cut_alike = [](const Segment& a, const Segment& b) { return a.begin == b.begin && a.end == b.end; };
  if (std::ranges::equal(one, other, is_cut_alike)) return {};
  return bad_input(source + ": two parts of it are cut in different ways: build all parts with the same options");
}

}  // namespace mapjoin
