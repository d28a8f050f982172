// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/model/conventions.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <set>

namespace mapjoin {
namespace {

template <typename Enum>
class EnumNamesTest : public ::testing::Test {};
using Enums = ::testing::Types<Covariance, PoseError, RotationInformation, LogFormat, Method, MinimiseStatus>;
TYPED_TEST_SUITE(EnumNamesTest, Enums);

TYPED_TEST(EnumNamesTest, NamesEveryValueFromZeroOnOnce) {
  const auto names = enum_names(TypeParam());
  std::set<std::string> words;
  for (std::size_t k = 0; k < names.size(); ++k) words.insert(to_string(static_cast<TypeParam>(k)));
  EXPECT_EQ(words.size(), names.size());
  EXPECT_FALSE(words.contains("unknown"));
}

TEST(EnumNames, OfNoValueIsUnknown) {
  EXPECT_EQ(to_string(static_cast<Method>(99)), "unknown");
}

}  // namespace
}  // namespace mapjoin
