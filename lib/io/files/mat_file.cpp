// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <matio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/files/system_call.hpp>
#include <memory>
#include <optional>

namespace mapjoin {
namespace {

constexpr std::size_t kMaxSparseSide = 10000;
constexpr std::size_t kLeastBytesARow = 8;  // A number at least.

struct CloseMat {
  void operator()(mat_t* mat) const { Mat_Close(mat); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Mat = std::unique_ptr<mat_t, CloseMat>;
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

/// matio opens by name only: the bytes go through a temporary file, which loses its name as soon as it is open.
Expected<Mat> open_mat(std::string_view bytes, const std::string& file) {
  std::error_code failure;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(failure);
  if (failure) return call_failed("the folder for temporary files", failure.value(), ErrorKind::kCannotWrite);
  std::string name = folder / "mapjoin-XXXXXX";
  const int descriptor = ::mkstemp(name.data());
  if (descriptor < 0) return call_failed(name, errno, ErrorKind::kCannotWrite);
  const int unwritten = write_all(descriptor, bytes);
  ::close(descriptor);
  Mat mat(unwritten == 0 ? Mat_Open(name.c_str(), MAT_ACC_RDONLY) : nullptr);
  ::unlink(name.c_str());
  if (unwritten != 0) return call_failed(name, unwritten, ErrorKind::kCannotWrite);
  if (!mat) return bad_input(fmt::format("{}: a damaged MAT file", file));
  return mat;
}

/// What is wrong with the variable, in a file of so many bytes, before its data are read, or nothing.
std::optional<Error> refusal(const matvar_t& variable, std::size_t bytes) {
  const bool sparse = variable.class_type == MAT_C_SPARSE;
  if (variable.rank != 2 || variable.isComplex != 0 || (variable.class_type != MAT_C_DOUBLE && !sparse)) {
    return Error{ErrorKind::kBadInput, "not a real matrix of doubles"};
  }
  const std::size_t rows = variable.dims[0];
  const std::size_t cols = variable.dims[1];
  const std::size_t most = std::min(kMaxSparseSide, bytes / kLeastBytesARow);
  if (!sparse || std::max(rows, cols) <= most) return std::nullopt;
  return Error{ErrorKind::kTooLarge, fmt::format("sparse, {} x {}, is more than {} rows or columns", rows, cols, most)};
}

/// Empty where the indices do not fit the matrix.
std::optional<Eigen::MatrixXd> dense(const mat_sparse_t& sparse, std::size_t rows, std::size_t cols) {
  if (sparse.njc != cols + 1 || sparse.nir < sparse.ndata || !sparse.jc || (sparse.ndata > 0 && !(sparse.ir && sparse.data))) {
    return std::nullopt;
  }
  const auto* values = static_cast<const double*>(sparse.data);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
  for (std::size_t col = 0; col < cols; ++col) {
    if (sparse.jc[col] > sparse.jc[col + 1] || sparse.jc[col + 1] > sparse.ndata) return std::nullopt;
    for (std::size_t k = sparse.jc[col]; k < sparse.jc[col + 1]; ++k) {
      if (sparse.ir[k] >= rows) return std::nullopt;
      matrix(static_cast<Eigen::Index>(sparse.ir[k]), static_cast<Eigen::Index>(col)) = values[k];
    }
  }
  return matrix;
}

/// The data of a variable that was not refused; empty where they are damaged.
std::optional<Eigen::MatrixXd> read_data(mat_t* mat, matvar_t& variable) {
  const std::size_t rows = variable.dims[0];
  const std::size_t cols = variable.dims[1];
  const bool empty = rows == 0 || cols == 0;
  if (!empty && (Mat_VarReadDataAll(mat, &variable) != 0 || !variable.data)) return std::nullopt;
  if (variable.class_type == MAT_C_SPARSE && !empty) {
    if (variable.data_type != MAT_T_DOUBLE) return std::nullopt;
    return dense(*static_cast<const mat_sparse_t*>(variable.data), rows, cols);
  }
  const auto* values = static_cast<const double*>(variable.data);
  return Eigen::Map<const Eigen::MatrixXd>(values, static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
}

}  // namespace

Expected<MatVariables> read_mat(std::string_view bytes, const std::string& file,
                                std::initializer_list<std::string_view> names) {
  const auto plain = checked_and_inflated(bytes, file);
  if (!plain) return tl::unexpected(plain.error());
  const auto mat = open_mat(*plain, file);
  if (!mat) return tl::unexpected(mat.error());
  MatVariables found;
  while (const Variable variable{Mat_VarReadNextInfo(mat->get())}) {
    const std::string_view name = variable->name ? variable->name : "";
    if (std::find(names.begin(), names.end(), name) == names.end()) continue;
    if (auto error = refusal(*variable, plain->size())) {
      error->message = fmt::format("{}: variable {}: {}", file, name, error->message);
      return tl::unexpected(*error);
    }
    auto matrix = read_data(mat->get(), *variable);
    if (!matrix) return bad_input(fmt::format("{}: variable {}: its data are damaged", file, name));
    found.insert_or_assign(std::string(name), std::move(*matrix));
  }
  return found;
}

}  // namespace mapjoin
