// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <mapjoin/io/store/store.hpp>
#include <set>
#include <string>
#include <tests/fuzz/targets.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::fuzz {
namespace {

namespace fs = std::filesystem;

class Corpus : public ::testing::TestWithParam<Target> {};

TEST_P(Corpus, KeepsThePromises) {
  const fs::path folder = fs::path(MAPJOIN_FUZZ_CORPUS) / GetParam().name;
  const std::set<fs::path> inputs(fs::directory_iterator(folder), fs::directory_iterator{});
  EXPECT_FALSE(inputs.empty());
  for (const fs::path& input : inputs) EXPECT_NO_THROW(GetParam().run(mapjoin::testing::content_of(input))) << input;
}

std::string name_of(const ::testing::TestParamInfo<Target>& target) {
  return std::string(target.param.name);
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, ::testing::ValuesIn(kTargets), name_of);

TEST(CorpusOfStores, IsOfTheVersionThatIsRead) {
  for (const char* name : {"plane", "space", "maps_alone"}) {
    const auto read = read_store(fs::path(MAPJOIN_FUZZ_CORPUS) / "store" / name);
    EXPECT_TRUE(read) << read.error().message;
  }
}

}  // namespace
}  // namespace mapjoin::fuzz
