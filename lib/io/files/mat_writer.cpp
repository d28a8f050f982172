// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/files/mat_format.hpp>

namespace mapjoin {
namespace {

using namespace mat;

static_assert(std::endian::native == std::endian::little, "the header says little-endian");

/// A data element: type, number of bytes, and the bytes, filled up to a multiple of eight.
std::string element(std::uint32_t type, const void* data, std::size_t size) {
  const std::array<std::uint32_t, 2> tag{type, static_cast<std::uint32_t>(size)};
  std::string bytes(sizeof tag + (size + 7) / 8 * 8, '\0');
  std::memcpy(bytes.data(), tag.data(), sizeof tag);
  if (size > 0) std::memcpy(bytes.data() + sizeof tag, data, size);
  return bytes;
}

/// The end of the sizes of a matrix: readers take a number of bytes for a signed one of 32 bits. Its name and tags take the
/// rest.
constexpr std::size_t kEndOfSizes = (std::size_t{1} << 31) - 4096;

std::string matrix(const std::string& name, const Eigen::MatrixXd& M) {
  const std::array<std::uint32_t, 2> flags{kDoubleClass, 0};
  const std::array<std::int32_t, 2> dimensions{static_cast<std::int32_t>(M.rows()), static_cast<std::int32_t>(M.cols())};
  const std::string parts = element(kUint32, flags.data(), sizeof flags) +
                            element(kInt32, dimensions.data(), sizeof dimensions) + element(kInt8, name.data(), name.size()) +
                            element(kDouble, M.data(), static_cast<std::size_t>(M.size()) * sizeof(double));
  return element(kMatrixElement, parts.data(), parts.size());
}

}  // namespace

Expected<std::string> mat_bytes(const std::vector<MatVariable>& variables, const std::string& file) {
  for (const auto& [name, M] : variables) {
    const std::size_t size = static_cast<std::size_t>(M.size()) * sizeof(double);
    if (size < kEndOfSizes) continue;
    return tl::unexpected(Error{
        ErrorKind::kTooLarge,
        fmt::format("{}: {} would take {:.1f} GB, and a variable of a MAT file takes less than 2 GiB; the text formats hold it",
                    file, name, static_cast<double>(size) / 1e9)});
  }
  constexpr std::size_t kTextSize = 124;
  std::string bytes = "MATLAB 5.0 MAT-file, written by mapjoin";
  bytes.resize(kTextSize, ' ');
  bytes += {'\0', '\1', 'I', 'M'};  // Version 1.0, and the order of bytes.
  for (const auto& [name, M] : variables) bytes += matrix(name, M);
  return bytes;
}

}  // namespace mapjoin
