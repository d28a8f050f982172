// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <matio.h>

#include <mapjoin/io/files/mat_file.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

/// The matrices in a MAT file, as matio reads them.
MatVariables read_by_matio(const std::filesystem::path& path) {
  MatVariables variables;
  mat_t* const file = Mat_Open(path.c_str(), MAT_ACC_RDONLY);
  while (matvar_t* const variable = file ? Mat_VarReadNext(file) : nullptr) {
    variables[variable->name] = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(variable->data),
                                                                  static_cast<Eigen::Index>(variable->dims[0]),
                                                                  static_cast<Eigen::Index>(variable->dims[1]));
    Mat_VarFree(variable);
  }
  if (file) Mat_Close(file);
  return variables;
}

TEST(MatWriter, WritesWhatMatioReads) {
  Eigen::MatrixXd odd(3, 1);
  odd << 1.0 / 3.0, -0.0, 1e300;
  const Eigen::MatrixXd wide = Eigen::MatrixXd::Random(2, 5);
  const std::string bytes = mat_bytes({{"odd", odd}, {"a_longer_name", wide}}, "some.mat").value();
  const testing::TemporaryFolder folder;
  const auto ours = read_mat(bytes, "some.mat", {"odd", "a_longer_name"});
  ASSERT_TRUE(ours) << ours.error().message;
  for (const MatVariables& variables : {read_by_matio(folder.file("some.mat", bytes)), *ours}) {
    ASSERT_EQ(variables.size(), 2U);
    EXPECT_EQ(variables.at("odd"), odd);
    EXPECT_TRUE(std::signbit(variables.at("odd")(1, 0)));
    EXPECT_EQ(variables.at("a_longer_name"), wide);
  }
}

TEST(MatWriter, WritesEmptyMatricesAndFilesWithoutAny) {
  const auto variables = read_mat(mat_bytes({{"none", Eigen::MatrixXd(0, 2)}}, "some.mat").value(), "some.mat", {"none"});
  ASSERT_TRUE(variables) << variables.error().message;
  EXPECT_EQ(variables->at("none").rows(), 0);
  EXPECT_TRUE(read_mat(mat_bytes({}, "some.mat").value(), "some.mat", {"none"})->empty());
}

TEST(MatWriter, RefusesAVariableForWhoseSizeTheFormatHasNoNumber) {
  std::vector<MatVariable> variables(1);
  variables[0] = {"poses", Eigen::MatrixXd()};
  variables[0].second.resize(Eigen::Index{1} << 28, 1);  // never touched, and so no memory
  const auto bytes = mat_bytes(variables, "some.mat");
  ASSERT_FALSE(bytes);
  EXPECT_EQ(bytes.error().kind, ErrorKind::kTooLarge);
  EXPECT_EQ(bytes.error().message,
            "some.mat: poses would take 2.1 GB, and a variable of a MAT file takes less than 2 GiB; the text formats hold it");
}

}  // namespace
}  // namespace mapjoin
