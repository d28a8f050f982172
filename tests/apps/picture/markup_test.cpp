// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <apps/picture/markup.hpp>
#include <cstdint>

namespace mapjoin::apps {
namespace {

TEST(Base64, IsAsInRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xfb\xff\xfe"), "+//+");
}

TEST(Base64, OfNumbersIsLittleEndian) {
  EXPECT_EQ(base64(std::vector<std::uint32_t>{1, 0x01020304}), base64(std::string_view("\1\0\0\0\4\3\2\1", 8)));
}

}  // namespace
}  // namespace mapjoin::apps
