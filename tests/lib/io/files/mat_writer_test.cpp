// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/io/files/mat_file.hpp>

namespace mapjoin {
namespace {

TEST(MatWriter, WritesWhatMatioReads) {
  Eigen::MatrixXd odd(3, 1);  // As a name of three letters, filled up to a multiple of eight bytes.
  odd << 1.0 / 3.0, -0.0, 1e300;
  const Eigen::MatrixXd wide = Eigen::MatrixXd::Random(2, 5);
  const auto variables = read_mat(mat_bytes({{"odd", odd}, {"a_longer_name", wide}}), "some.mat", {"odd", "a_longer_name"});
  ASSERT_TRUE(variables) << variables.error().message;
  EXPECT_EQ(variables->at("odd"), odd);
  EXPECT_TRUE(std::signbit(variables->at("odd")(1, 0)));
  EXPECT_EQ(variables->at("a_longer_name"), wide);
}

TEST(MatWriter, WritesEmptyMatricesAndFilesWithoutAny) {
  const auto variables = read_mat(mat_bytes({{"none", Eigen::MatrixXd(0, 2)}}), "some.mat", {"none"});
  ASSERT_TRUE(variables) << variables.error().message;
  EXPECT_EQ(variables->at("none").rows(), 0);
  EXPECT_TRUE(read_mat(mat_bytes({}), "some.mat", {"none"})->empty());
}

}  // namespace
}  // namespace mapjoin
