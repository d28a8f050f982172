// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/model/ids.hpp>

namespace mapjoin {
namespace {

TEST(Ids, SymbolsAreWrittenAsALetterAndAnIndexAndReadBack) {
  for (const auto& [key, text] :
       std::vector<std::pair<std::uint64_t, std::string>>{{17, "17"},
                                                          {6989586621679009792u, "a0"},
                                                          {7061644215716937729u, "b1"},
                                                          {1'600'000'000'123'456'789u, "1600000000123456789"},
                                                          {~std::uint64_t{0}, "18446744073709551615"}}) {
    EXPECT_EQ(key_text(key), text);
    EXPECT_EQ(parse_key(text), key);
  }
  EXPECT_EQ(to_string(PoseId{2, 7061644215716937729u}), "pose b1 of session 2");
  for (const char* wrong : {"", "a", "-1", "a-1", "1a", "18446744073709551616", "a72057594037927936"}) {
    EXPECT_FALSE(parse_key(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace mapjoin
