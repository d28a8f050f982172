// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <apps/picture/markup.hpp>
#include <cstdint>

namespace mapjoin::apps {
namespace {

TEST(Escaped, HasEntitiesForWhatMarkupIsMadeOf) {
  EXPECT_EQ(escaped("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
  EXPECT_EQ(escaped("\u00e9 \u20ac \U0001F600\t\n"), "\u00e9 \u20ac \U0001F600\t\n");
}

TEST(Escaped, HasAReplacementForWhatNoTextIs) {
  EXPECT_EQ(escaped("a\xe9.g2o"), "a\uFFFD.g2o");
  EXPECT_EQ(escaped(std::string_view("\0\x1b\x7f", 3)), "\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(escaped("\xc3"), "\uFFFD") << "cut short";
  EXPECT_EQ(escaped("\xe2\x82"), "\uFFFD\uFFFD") << "cut short";
  EXPECT_EQ(escaped("\xc0\xaf"), "\uFFFD\uFFFD") << "longer than need be";
  EXPECT_EQ(escaped("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD") << "a surrogate";
  EXPECT_EQ(escaped("\xf4\x90\x80\x80"), "\uFFFD\uFFFD\uFFFD\uFFFD") << "beyond U+10FFFF";
  EXPECT_EQ(escaped("\uFFFE\uFFFF"), "\uFFFD\uFFFD\uFFFD\uFFFD\uFFFD\uFFFD") << "no characters, by byte";
}

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
