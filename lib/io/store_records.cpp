// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/store_records.hpp>

namespace mapjoin::store {

std::string encode_upper(const Eigen::MatrixXd& matrix) {
  std::string bytes;
  bytes.reserve(static_cast<std::size_t>(matrix.rows() * (matrix.rows() + 1) / 2) * sizeof(double));
  for (Eigen::Index col = 0; col < matrix.cols(); ++col) {
    bytes.append(reinterpret_cast<const char*>(matrix.col(col).data()), static_cast<std::size_t>(col + 1) * sizeof(double));
  }
  return bytes;
}

std::optional<Eigen::MatrixXd> decode_upper(std::string_view bytes, Eigen::Index rows) {
  if (bytes.size() != static_cast<std::size_t>(rows * (rows + 1) / 2) * sizeof(double)) return std::nullopt;
  Eigen::MatrixXd matrix(rows, rows);
  const char* at = bytes.data();
  for (Eigen::Index col = 0; col < rows; ++col) {
    std::memcpy(matrix.col(col).data(), at, static_cast<std::size_t>(col + 1) * sizeof(double));
    at += static_cast<std::size_t>(col + 1) * sizeof(double);
  }
  return matrix;
}

}  // namespace mapjoin::store
