// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/files/mat_format.hpp>

namespace mapjoin {
namespace {

using namespace mat;

constexpr std::size_t kMaxSparseSide = 10000;
constexpr std::size_t kLeastBytesARow = 8;  // One number at least.

/// The version and the byte order in the header.
constexpr std::string_view kVersion5("\0\1IM", 4);
constexpr std::string_view kVersion73("\0\2IM", 4);  // HDF5 behind the header.
constexpr std::string_view kBigEndian5("\1\0MI", 4);

std::uint32_t word(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// One part of a matrix element: its tag and its data, padded to eight bytes.
struct Part {
  std::uint32_t type = 0;
  std::size_t begin = 0;  ///< Offset of the data in the element.
  std::size_t size = 0;   ///< Bytes of data, without padding.
  std::size_t end = 0;
};

template <typename Number>
double number_at(const char* bytes) {
  Number number{};
  std::memcpy(&number, bytes, sizeof number);
  return static_cast<double>(number);
}

/// The representation of a number in the file.
struct Type {
  std::size_t width = 0;  ///< Bytes of a number; 0 for types without numbers.
  double (*number_at)(const char* bytes) = nullptr;
};
template <typename Number>
constexpr Type kType{sizeof(Number), number_at<Number>};

/// The types 0 to 13.
constexpr Type kTypes[] = {{},
                           kType<std::int8_t>,
                           kType<std::uint8_t>,
                           kType<std::int16_t>,
                           kType<std::uint16_t>,
                           kType<std::int32_t>,
                           kType<std::uint32_t>,
                           kType<float>,
                           {},
                           kType<double>,
                           {},
                           {},
                           kType<std::int64_t>,
                           kType<std::uint64_t>};

Type type_of(const Part& part) {
  return part.type < std::size(kTypes) ? kTypes[part.type] : Type{};
}

/// The count of numbers that a part has room for; nullopt if its type has none.
std::optional<std::size_t> numbers(const Part& part) {
  const std::size_t width = type_of(part).width;
  return width == 0 ? std::nullopt : std::optional(part.size / width);
}

/// The parts of a matrix element: flags, dimensions, name, and data; nullopt if they do not fill it.
std::optional<std::vector<Part>> parts(std::string_view element) {
  std::vector<Part> all;
  for (std::size_t at = kTagSize; at < element.size(); at = all.back().end) {
    if (element.size() - at < kTagSize) return std::nullopt;
    const std::uint32_t first = word(element, at);
    // Up to four bytes of data are kept in the tag itself, with their size in its upper half.
    const bool is_small = first >> 16 != 0;
    const std::size_t size = is_small ? first >> 16 : word(element, at + 4);
    const std::size_t begin = at + (is_small ? 4 : kTagSize);
    const std::size_t end = is_small ? at + kTagSize : begin + (size + 7) / 8 * 8;
    if (end > element.size() || begin + size > end) return std::nullopt;
    all.push_back({is_small ? first & 0xffff : first, begin, size, end});
  }
  return all;
}

/// The class of a matrix element whose flags are in place.
std::uint32_t class_of(std::string_view element) {
  return word(element, 2 * kTagSize) & 0xff;
}

/// True unless it holds further variables, or an object of MATLAB's (a string, a table, a time), which has no dimensions.
bool is_of_matrix_class(std::string_view element) {
  return class_of(element) >= kFirstMatrixClass && class_of(element) <= kLastMatrixClass;
}

/// True if the parts behind the name of a sparse matrix are its row indices, its column ends and its values, in sizes that
/// agree.
bool is_sparse(const std::vector<Part>& all, std::size_t cols) {
  const auto are_indices = [](const Part& part) { return part.type == kInt32 || part.type == kUint32; };
  if (all.size() < 6 || !are_indices(all[3]) || !are_indices(all[4])) return false;
  const auto values = numbers(all[5]);
  return numbers(all[4]) == cols + 1 && values && *values <= numbers(all[3]);
}

/// True if a matrix element's parts fill it and a matrix of doubles has as many numbers as its dimensions say.
bool sizes_agree(std::string_view element) {
  const auto all = parts(element);
  if (!all || all->empty()) return false;
  const Part& flags = (*all)[0];
  if (flags.type != kUint32 || flags.size != 8) return false;
  if (!is_of_matrix_class(element)) return true;
  if (all->size() < 3) return false;
  const Part& dimensions = (*all)[1];
  if (dimensions.type != kInt32 || dimensions.size < 8 || dimensions.size % 4 != 0) return false;
  const std::uint32_t held = class_of(element);
  const bool is_matrix = dimensions.size == 8;
  if (!is_matrix || (held != kDoubleClass && held != kSparseClass)) return true;
  const std::size_t rows = word(element, dimensions.begin);
  const std::size_t cols = word(element, dimensions.begin + 4);
  if (held == kSparseClass) return is_sparse(*all, cols);
  const bool is_empty = rows * cols == 0 && all->size() == 3;
  return is_empty || (all->size() > 3 && numbers((*all)[3]) == rows * cols);
}

/// The numbers of a part.
std::vector<double> values_of(std::string_view element, const Part& part) {
  const Type type = type_of(part);
  std::vector<double> values(part.size / type.width);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = type.number_at(element.data() + part.begin + k * type.width);
  return values;
}

/// The sparse matrix of these parts as a dense one; bad input if an index is outside the matrix.
Expected<Eigen::MatrixXd> dense(std::string_view element, const std::vector<Part>& parts, std::size_t rows, std::size_t cols) {
  const auto row_of = [&](std::size_t k) { return std::size_t{word(element, parts[3].begin + 4 * k)}; };
  const auto begin_of = [&](std::size_t col) { return std::size_t{word(element, parts[4].begin + 4 * col)}; };
  const std::vector<double> values = values_of(element, parts[5]);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
  for (std::size_t col = 0; col < cols; ++col) {
    if (begin_of(col) > begin_of(col + 1) || begin_of(col + 1) > values.size()) return bad_input("its data are damaged");
    for (std::size_t k = begin_of(col); k < begin_of(col + 1); ++k) {
      if (row_of(k) >= rows) return bad_input("its data are damaged");
      matrix(static_cast<Eigen::Index>(row_of(k)), static_cast<Eigen::Index>(col)) = values[k];
    }
  }
  return matrix;
}

/// The matrix in an element whose sizes agree; the file has `bytes` bytes. Bad input unless it holds real doubles; kTooLarge.
Expected<Eigen::MatrixXd> matrix_of(std::string_view element, const std::vector<Part>& parts, std::size_t bytes) {
  const bool is_complex = (word(element, 2 * kTagSize) & kComplexFlag) != 0;
  const bool sparse = class_of(element) == kSparseClass;
  if (parts[1].size != 8 || is_complex || (class_of(element) != kDoubleClass && !sparse)) {
    return bad_input("not a real matrix of doubles");
  }
  const std::size_t rows = word(element, parts[1].begin);
  const std::size_t cols = word(element, parts[1].begin + 4);
  if (sparse) {
    const std::size_t most = std::min(kMaxSparseSide, bytes / kLeastBytesARow);
    if (std::max(rows, cols) <= most) return dense(element, parts, rows, cols);
    return tl::unexpected(
        Error{ErrorKind::kTooLarge, fmt::format("sparse, {} x {}, is more than {} rows or columns", rows, cols, most)});
  }
  const std::vector<double> values = rows * cols == 0 ? std::vector<double>() : values_of(element, parts[3]);
  return Eigen::Map<const Eigen::MatrixXd>(values.data(), static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
}

/// The version and the byte order that a MAT file's header gives; empty if it is too short.
std::string_view version_of(std::string_view bytes) {
  return bytes.size() < kHeaderSize ? std::string_view() : bytes.substr(124, 4);
}

/// True if a file begins with a little-endian matrix of doubles, as those of version 4 do, which have no header: a type of 0,
/// the numbers of rows and columns, whether it is complex, and the length of its name.
bool is_of_version_4(std::string_view bytes) {
  constexpr std::size_t kWords = 5;
  constexpr std::uint32_t kLongestName = 64;
  if (bytes.size() < kWords * sizeof(std::uint32_t)) return false;
  const auto number = [&](std::size_t k) { return word(bytes, k * sizeof(std::uint32_t)); };
  return number(0) == 0 && number(1) > 0 && number(2) > 0 && number(3) <= 1 && number(4) > 0 && number(4) <= kLongestName;
}

}  // namespace

bool is_mat_file(std::string_view bytes) {
  const std::string_view version = version_of(bytes);
  return version == kVersion5 || version == kVersion73 || version == kBigEndian5 || is_of_version_4(bytes);
}

Expected<std::string> checked_and_inflated(std::string_view bytes, const std::string& file, std::size_t most) {
  const auto damaged = [&] { return bad_input(fmt::format("{}: a MAT file that is damaged or cut short", file)); };
  if (version_of(bytes) == kVersion73) return bad_input(fmt::format("{}: a MAT file of version 7.3: save it with -v7", file));
  if (version_of(bytes) == kBigEndian5) return bad_input(fmt::format("{}: a MAT file of a big-endian machine", file));
  if (is_of_version_4(bytes)) return bad_input(fmt::format("{}: a MAT file of version 4: save it with -v7", file));
  if (version_of(bytes) != kVersion5) return bad_input(fmt::format("{}: not a MAT file of version 5, 6 or 7", file));
  std::string plain(bytes.substr(0, kHeaderSize));
  bytes.remove_prefix(kHeaderSize);
  while (!bytes.empty()) {
    if (bytes.size() < kTagSize || word(bytes, 4) > bytes.size() - kTagSize) return damaged();
    const std::string_view element = bytes.substr(0, kTagSize + word(bytes, 4));
    const std::size_t begin = plain.size();
    if (word(element, 0) != kCompressedElement) {
      plain += element;
    } else {
      std::string_view packed = element.substr(kTagSize);
      const Inflated end = append_inflated(Wrapping::kZlib, packed, most, plain);
      if (end != Inflated::kWhole && end != Inflated::kTooLarge) return damaged();
    }
    if (plain.size() > most) {
      return tl::unexpected(Error{ErrorKind::kTooLarge, fmt::format("{}: unpacks to more than {} MB", file, most >> 20)});
    }
    const std::string_view inflated = std::string_view(plain).substr(begin);
    if (inflated.size() < kTagSize || word(inflated, 0) != kMatrixElement || word(inflated, 4) != inflated.size() - kTagSize ||
        !sizes_agree(inflated)) {
      return damaged();
    }
    if (!is_of_matrix_class(inflated)) plain.resize(begin);
    bytes.remove_prefix(element.size());
  }
  return plain;
}

Expected<MatVariables> read_mat(std::string_view bytes, const std::string& file,
                                std::initializer_list<std::string_view> names) {
  const auto plain = checked_and_inflated(bytes, file);
  if (!plain) return tl::unexpected(plain.error());
  MatVariables found;
  for (std::size_t at = kHeaderSize; at < plain->size(); at += kTagSize + word(*plain, at + 4)) {
    const std::string_view element = std::string_view(*plain).substr(at, kTagSize + word(*plain, at + 4));
    const std::vector<Part> all = *parts(element);
    const std::string name(element.substr(all[2].begin, all[2].size));
    if (std::find(names.begin(), names.end(), name) == names.end()) continue;
    auto matrix = matrix_of(element, all, plain->size());
    if (!matrix) {
      return tl::unexpected(Error{matrix.error().kind, fmt::format("{}: variable {}: {}", file, name, matrix.error().message)});
    }
    found.insert_or_assign(name, *std::move(matrix));
  }
  return found;
}

}  // namespace mapjoin
