// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <mapjoin/io/files/text_scanner.hpp>
#include <string>
#include <tests/support/error_of.hpp>
#include <vector>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;

/// The error of reading the first line of `text` as `numbers` numbers.
std::string message_about(const std::string& text, int numbers) {
  TextScanner scanner("some.txt", text);
  scanner.next_line();
  for (int i = 0; i < numbers; ++i) scanner.number();
  return testing::error_of(scanner.finish_line());
}

TEST(TextScanner, FallsIntoPiecesOfWholeLinesThatKnowTheirPlace) {
  std::string text = "\xef\xbb\xbf";
  for (int line = 1; line <= 200; ++line) text += std::to_string(line) + (line % 3 == 0 ? "\n" : " x\r\n");
  text += "201";
  for (const std::size_t bytes : {1u, 7u, 100u, 5000u}) {
    std::size_t next = 1;
    for (TextScanner piece : TextScanner("some.txt", text).pieces(bytes)) {
      while (piece.next_line()) {
        EXPECT_EQ(piece.key(), next) << bytes;
        EXPECT_EQ(piece.place().line, next++) << bytes;
      }
    }
    EXPECT_EQ(next, 202u) << bytes;
  }
  EXPECT_TRUE(TextScanner("some.txt", "").pieces(100).empty());
}

TEST(TextScanner, PassesOverBlankLinesCommentsAndBothLineEnds) {
  TextScanner text("some.txt", "\xef\xbb\xbf# comment\r\n\r\n  \t\nfirst 1\r\n\n# 2\n second\t2 # rest\nlast");
  ASSERT_TRUE(text.next_line());
  EXPECT_EQ(text.word(), "first");
  EXPECT_EQ(text.number(), 1.0);
  EXPECT_TRUE(text.finish_line());
  ASSERT_TRUE(text.next_line());
  EXPECT_EQ(text.word(), "second");
  EXPECT_EQ(text.place().line, 7u);
  EXPECT_EQ(text.place().column, 2u);
  EXPECT_EQ(text.number(), 2.0);
  EXPECT_TRUE(text.finish_line());
  ASSERT_TRUE(text.next_line());
  EXPECT_EQ(text.word(), "last");
  EXPECT_EQ(text.word(), "");
  EXPECT_FALSE(text.next_line());
  EXPECT_FALSE(text.next_line());
}

TEST(TextScanner, SkipsWhatIsLeftOfALine) {
  TextScanner text("some.txt", "a b c\nd");
  ASSERT_TRUE(text.next_line());
  EXPECT_EQ(text.word(), "a");
  ASSERT_TRUE(text.next_line());
  EXPECT_EQ(text.word(), "d");
}

TEST(TextScanner, ReadsNumbersAsTheCLibraryDoes) {
  for (const char* const digits :
       {"0", "7", "-0", "100", "999999999999999", "1234567890123456789", "0.1", "-2.5e-3", "1E5", "5.", ".5", "6.02214076e23",
        "4.9e-324", "1.7976931348623157e308", "0.30000000000000004", "007"}) {
    TextScanner text("some.txt", digits);
    ASSERT_TRUE(text.next_line());
    const double number = text.number();
    EXPECT_TRUE(text.finish_line()) << digits;
    EXPECT_EQ(number, std::strtod(digits, nullptr)) << digits;
    EXPECT_EQ(std::signbit(number), digits[0] == '-') << digits;
  }
}

TEST(TextScanner, ReadsAPlusSignAndWhatIsTooSmallForADouble) {
  TextScanner text("some.txt", "+1.5 +3 1e-400 -1e-400");
  ASSERT_TRUE(text.next_line());
  EXPECT_EQ(text.number(), 1.5);
  EXPECT_EQ(text.key(), 3u);
  EXPECT_EQ(text.number(), 0.0);
  EXPECT_EQ(text.number(), 0.0);
  EXPECT_TRUE(text.finish_line());
}

TEST(TextScanner, TakesANumberThatIsTooSmallForZeroHoweverItIsWritten) {
  const std::string small = "0." + std::string(400, '0') + "1";
  for (const std::string& word : std::vector<std::string>{small, small + "e5", "1000e-400", "0e9223372036854775807",
                                                          "1e-99999999999999999999", "-.5E-350"}) {
    TextScanner text("some.txt", word);
    ASSERT_TRUE(text.next_line());
    EXPECT_EQ(text.number(), 0.0) << word;
    EXPECT_TRUE(text.finish_line()) << word;
  }
}

TEST(TextScanner, APlaceBeforeTheFirstWordIsWhereItWillBe) {
  TextScanner text("some.txt", "a\n  \n  b\n");
  for (const Place expected : {Place{1, 1}, Place{3, 3}}) {
    ASSERT_TRUE(text.next_line());
    EXPECT_EQ(text.place().line, expected.line);
    EXPECT_EQ(text.place().column, expected.column);
  }
  EXPECT_FALSE(text.next_line());
  EXPECT_EQ(text.error("the end").value().message, "some.txt:4:1: the end");
}

TEST(TextScanner, RefusesWhatIsNoFiniteNumber) {
  const std::string too_large = "1" + std::string(400, '0') + "e-5";
  for (const std::string word : {"nan", "inf", "-inf", "1e400", "0.001e400", "1e99999999999999999999", "1,5", "0x10", "1.2.3",
                                 "--1", "+-1", "1e", "x"}) {
    EXPECT_EQ(message_about(word, 1), "some.txt:1:1: '" + word + "' stands where a number is expected");
  }
  EXPECT_THAT(message_about(too_large, 1), HasSubstr("stands where a number is expected"));
}

TEST(TextScanner, NamesLineAndColumnOfTheFirstFailureOnly) {
  EXPECT_EQ(message_about("\n  1 2,0 3x", 3), "some.txt:2:5: '2,0' stands where a number is expected");
  EXPECT_EQ(message_about("1 2", 3), "some.txt:1:4: the line ends where a number is expected");
  EXPECT_EQ(message_about("1 2 3 4", 3), "some.txt:1:7: '4' stands where the line should end");
}

TEST(TextScanner, StartsEveryLineWithoutFailure) {
  TextScanner text("some.txt", "x\n1");
  ASSERT_TRUE(text.next_line());
  text.number();
  ASSERT_TRUE(text.next_line());
  EXPECT_EQ(text.number(), 1.0);
  EXPECT_TRUE(text.finish_line());
}

TEST(TextScanner, ReadsIdsOf64BitsAndRefusesOthers) {
  TextScanner text("some.txt", "18446744073709551615 -5\n-1\n18446744073709551616\n1.0");
  ASSERT_TRUE(text.next_line());
  EXPECT_EQ(text.key(), ~std::uint64_t{0});
  EXPECT_EQ(text.integer(), -5);
  EXPECT_TRUE(text.finish_line());
  while (text.next_line()) {
    text.key();
    EXPECT_FALSE(text.finish_line());
  }
}

TEST(TextScanner, ReadsTheUpperTriangleOfASymmetricMatrix) {
  TextScanner text("some.txt", "1 2 3 4 5 6");
  ASSERT_TRUE(text.next_line());
  const Matrix<3> expected = (Matrix<3>() << 1, 2, 3, 2, 4, 5, 3, 5, 6).finished();
  EXPECT_EQ(text.symmetric<3>(), expected);
}

TEST(TextScanner, QuotesWithoutControlCharactersAndInShort) {
  EXPECT_EQ(in_quotes("a\x1b[2Jb"), "'a?[2Jb'");
  EXPECT_EQ(in_quotes(std::string(100, 'a')), "'" + std::string(40, 'a') + "...'");
}

TEST(TextScanner, AnIdMayBeASymbol) {
  TextScanner text("some.txt", "b1 7 x 1\n");
  text.next_line();
  EXPECT_EQ(text.key(), 7061644215716937729u);
  EXPECT_EQ(text.key(), 7u);
  text.key();
  EXPECT_EQ(text.finish_line().error().message, "some.txt:1:6: 'x' stands where an id is expected");
}

}  // namespace
}  // namespace mapjoin
