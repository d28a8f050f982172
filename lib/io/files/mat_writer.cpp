// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/files/mat_format.hpp>
#include <stdexcept>

namespace mapjoin {
namespace {

using namespace mat;

static_assert(std::endian::native == std::endian::little, "the header says little-endian");

/// A data element: type, number of bytes, and the bytes, filled up to a multiple of eight.
std::string element(std::uint32_t type, const void* data, std::size_t size) {
  constexpr std::size_t kMost = std::size_t{1} << 31;
  if (size >= kMost) throw std::length_error("mat_bytes: a variable is too large for a MAT file of version 5");
  const std::array<std::uint32_t, 2> tag{type, static_cast<std::uint32_t>(size)};
  std::string bytes(sizeof tag + (size + 7) / 8 * 8, '\0');
  std::memcpy(bytes.data(), tag.data(), sizeof tag);
  if (size > 0) std::memcpy(bytes.data() + sizeof tag, data, size);
  return bytes;
}

std::string matrix(const std::string& name, const Eigen::MatrixXd& M) {
  const std::array<std::uint32_t, 2> flags{kDoubleClass, 0};
  const std::array<std::int32_t, 2> dimensions{static_cast<std::int32_t>(M.rows()), static_cast<std::int32_t>(M.cols())};
  const std::string parts = element(kUint32, flags.data(), sizeof flags) +
                            element(kInt32, dimensions.data(), sizeof dimensions) + element(kInt8, name.data(), name.size()) +
                            element(kDouble, M.data(), static_cast<std::size_t>(M.size()) * sizeof(double));
  return element(kMatrixElement, parts.data(), parts.size());
}

}  // namespace

std::string mat_bytes(const std::vector<std::pair<std::string, Eigen::MatrixXd>>& variables) {
  constexpr std::size_t kTextSize = 124;
  std::string bytes = "MATLAB 5.0 MAT-file, written by mapjoin";
  bytes.resize(kTextSize, ' ');
  bytes += {'\0', '\1', 'I', 'M'};  // Version 1.0, and the order of bytes.
  for (const auto& [name, M] : variables) bytes += matrix(name, M);
  return bytes;
}

}  // namespace mapjoin
