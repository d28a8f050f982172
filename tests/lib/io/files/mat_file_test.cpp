// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <mapjoin/io/files/mat_file.hpp>
#include <numeric>
#include <tests/support/file_bytes.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;

class MatFileTest : public ::testing::Test {
 protected:
  MatFileTest() : mat_(Mat_CreateVer(path().c_str(), nullptr, MAT_FT_MAT5)) {}
  ~MatFileTest() override { close(); }

  std::string path() const { return (folder_.path() / "test.mat").string(); }
  void put(matvar_t* variable, matio_compression compression) {
    Mat_VarWrite(mat_, variable, compression);
    Mat_VarFree(variable);
  }
  void put(const char* name, Eigen::MatrixXd value, matio_compression compression = MAT_COMPRESSION_NONE) {
    std::size_t dims[2] = {static_cast<std::size_t>(value.rows()), static_cast<std::size_t>(value.cols())};
    put(Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, value.data(), 0), compression);
  }
  /// Puts the sparse matrix [[1.5, 0, 0], [0, 0, 2.5]], with `row` as the row of 2.5.
  void put_sparse(const char* name, mat_uint32_t row = 1) {
    mat_uint32_t ir[] = {0, row};
    mat_uint32_t jc[] = {0, 1, 1, 2};
    double values[] = {1.5, 2.5};
    mat_sparse_t sparse{2, ir, 2, jc, 4, 2, values};
    std::size_t dims[2] = {2, 3};
    put(Mat_VarCreate(name, MAT_C_SPARSE, MAT_T_DOUBLE, 2, dims, &sparse, MAT_F_DONT_COPY_DATA), MAT_COMPRESSION_NONE);
  }
  /// Closes the file, and returns its content.
  std::string bytes() {
    close();
    return testing::bytes_of(path());
  }

 private:
  void close() {
    if (mat_) Mat_Close(mat_);
    mat_ = nullptr;
  }
  testing::TemporaryFolder folder_;
  mat_t* mat_;
};

TEST_F(MatFileTest, ReadsTheNamedMatricesDenseAndSparse) {
  Eigen::MatrixXd a(2, 3);
  a << 1.0, 0.1, -3e300, 4.0, 5.0, 6.0;
  put("a", a);
  put("compressed", a.transpose(), MAT_COMPRESSION_ZLIB);
  put("unwanted", a);
  put_sparse("sparse");
  const auto found = read_mat(bytes(), "f.mat", {"a", "compressed", "sparse", "absent"});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->size(), 3u);
  EXPECT_EQ(found->at("a"), a);
  EXPECT_EQ(found->at("compressed"), a.transpose());
  EXPECT_EQ(found->at("sparse"), (Eigen::MatrixXd(2, 3) << 1.5, 0, 0, 0, 0, 2.5).finished());
}

TEST_F(MatFileTest, RefusesWhatIsNotARealMatrixOfDoubles) {
  std::int32_t value = 7;
  std::size_t dims[2] = {1, 1};
  put(Mat_VarCreate("count", MAT_C_INT32, MAT_T_INT32, 2, dims, &value, 0), MAT_COMPRESSION_NONE);
  EXPECT_EQ(read_mat(bytes(), "f.mat", {"count"}).error().message, "f.mat: variable count: not a real matrix of doubles");
}

TEST_F(MatFileTest, RefusesSizesThatDoNotAgreeBeforeAskingForMemory) {
  put("a", Eigen::MatrixXd::Ones(3, 3));
  const std::string whole = bytes();
  // The dimensions are behind 128 bytes of the file's header, 8 of the variable's tag, 16 of its flags and 8 of their own tag.
  for (const std::size_t at : {160u, 163u, 164u, 167u}) {
    std::string content = whole;
    content[at] = '\x7f';
    EXPECT_THAT(read_mat(content, "f.mat", {"a"}).error().message, HasSubstr("damaged")) << at;
  }
}

TEST_F(MatFileTest, RefusesFlagsAndDimensionsThatAreNotWholeNumbersOfTheirType) {
  put("a", Eigen::MatrixXd::Ones(3, 3));
  std::string other_type = bytes();
  std::string other_flags = other_type;
  std::string longer = other_type;
  other_type[152] = '\x6';
  other_flags[136] = '\x5';
  longer.insert(168, 8, '\0');  // nine bytes of dimensions are padded to sixteen
  longer[156] = '\x9';
  longer[132] = static_cast<char>(longer[132] + 8);  // the size of the whole variable
  for (const std::string& content : {other_type, other_flags, longer}) {
    const auto found = read_mat(content, "f.mat", {"a"});
    ASSERT_FALSE(found);
    EXPECT_THAT(found.error().message, HasSubstr("damaged"));
  }
}

TEST_F(MatFileTest, RefusesASparseMatrixOfMoreRowsThanTheFileHasRoomForBeforeAskingForMemory) {
  put_sparse("sparse");
  std::string content = bytes();
  content[160] = '\xff';  // the lowest byte of the number of rows
  const auto found = read_mat(content, "f.mat", {"sparse"});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, ErrorKind::kTooLarge);
  EXPECT_THAT(found.error().message, HasSubstr("f.mat: variable sparse: sparse, 255 x 3, is more than "));
}

TEST_F(MatFileTest, RefusesASparseMatrixWhosePartsAreOfOtherTypes) {
  put_sparse("sparse");
  const std::string whole = bytes();
  // The types of the row indices, of the ends of columns and of the values, behind the dimensions and the name.
  for (const std::size_t at : {184u, 200u, 224u}) {
    std::string content = whole;
    ASSERT_THAT(content[at], ::testing::AnyOf(6, 9)) << at;
    content[at] = '\x7f';
    EXPECT_THAT(read_mat(content, "f.mat", {"sparse"}).error().message, HasSubstr("damaged")) << at;
  }
}

TEST_F(MatFileTest, PassesOverCellsWhateverTheyPromise) {
  std::size_t dims[2] = {1, 1};
  double value = 7.0;
  matvar_t* number = Mat_VarCreate("", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, &value, 0);
  put(Mat_VarCreate("cells", MAT_C_CELL, MAT_T_CELL, 2, dims, &number, 0), MAT_COMPRESSION_NONE);
  put("a", Eigen::MatrixXd::Ones(2, 2));
  std::string content = bytes();
  content[160 + 3] = '\x7f';  // two thousand million cells
  const auto found = read_mat(content, "f.mat", {"a"});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->at("a"), Eigen::MatrixXd::Ones(2, 2));
}

TEST_F(MatFileTest, PassesOverObjectsOfMatlab) {
  put("a", Eigen::MatrixXd::Ones(2, 2));
  // A string: its tag, its flags with class 17, its name in the tag, and two names of what it is; no dimensions.
  const std::string string(
      "\16\0\0\0\50\0\0\0"
      "\6\0\0\0\10\0\0\0\21\0\0\0\0\0\0\0"
      "\1\0\1\0s\0\0\0"
      "\1\0\4\0MCOS"
      "\1\0\3\0str\0",
      48);
  const auto found = read_mat(bytes() + string, "f.mat", {"a"});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->at("a"), Eigen::MatrixXd::Ones(2, 2));
}

TEST_F(MatFileTest, RefusesASparseMatrixWithAnIndexOutsideIt) {
  put_sparse("sparse", 2);
  EXPECT_EQ(read_mat(bytes(), "f.mat", {"sparse"}).error().message, "f.mat: variable sparse: its data are damaged");
}

TEST_F(MatFileTest, RefusesOtherFilesAndSurvivesEveryCut) {
  put("a", Eigen::MatrixXd::Ones(5, 5), MAT_COMPRESSION_ZLIB);
  const std::string whole = bytes();
  EXPECT_TRUE(is_mat_file(whole));
  EXPECT_FALSE(is_mat_file("VERTEX_SE2 0 0 0 0\n"));
  EXPECT_THAT(read_mat("VERTEX_SE2 0 0 0 0\n", "f.mat", {"a"}).error().message, HasSubstr("f.mat: not a MAT file"));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto found = read_mat(whole.substr(0, size), "f.mat", {"a"});
    EXPECT_FALSE(found && found->contains("a")) << size;
  }
}

TEST_F(MatFileTest, NamesTheVersionsThatItDoesNotRead) {
  const auto header = [](const std::string& version) { return std::string("MATLAB").append(118, ' ') + version; };
  for (const auto& [version, part] : {std::pair(std::string("\0\2IM", 4), "f.mat: a MAT file of version 7.3: save it with -v7"),
                                      std::pair(std::string("\1\0MI", 4), "f.mat: a MAT file of a big-endian machine")}) {
    EXPECT_TRUE(is_mat_file(header(version)));
    EXPECT_EQ(read_mat(header(version), "f.mat", {"a"}).error().message, part);
  }
  const std::string version_4("\0\0\0\0\1\0\0\0\1\0\0\0\0\0\0\0\2\0\0\0a\0\0\0\0\0\0\0\0\0", 30);
  EXPECT_TRUE(is_mat_file(version_4));
  EXPECT_EQ(read_mat(version_4, "f.mat", {"a"}).error().message, "f.mat: a MAT file of version 4: save it with -v7");
}

TEST_F(MatFileTest, IsTooLargeRatherThanDamagedWhereItUnpacksToMoreThanAllowed) {
  put("a", Eigen::MatrixXd::Zero(1000, 1000), MAT_COMPRESSION_ZLIB);
  const std::string packed = bytes();
  EXPECT_TRUE(checked_and_inflated(packed, "f.mat", std::size_t{8} << 20));
  const auto inflated = checked_and_inflated(packed, "f.mat", std::size_t{7} << 20);
  ASSERT_FALSE(inflated);
  EXPECT_EQ(inflated.error().kind, ErrorKind::kTooLarge);
  EXPECT_EQ(inflated.error().message, "f.mat: unpacks to more than 7 MB");
}

TEST_F(MatFileTest, NoticesAFlippedBitOfAnyByteOfACompressedVariable) {
  put("a", Eigen::MatrixXd::Random(4, 4), MAT_COMPRESSION_ZLIB);
  const std::string whole = bytes();
  // The compressed data begin behind the header of the file and the tag of the element.
  for (std::size_t at = 136; at < whole.size(); ++at) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << at % 8));
    EXPECT_FALSE(read_mat(flipped, "f.mat", {"a"})) << at;
  }
}

}  // namespace
}  // namespace mapjoin
