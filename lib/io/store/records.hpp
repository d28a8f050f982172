// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The values of a log and of its local maps as records of fixed size, little-endian (docs/store.md).

#include <bit>
#include <cstring>
#include <mapjoin/model/factor_graph.hpp>
#include <mapjoin/model/segment.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace mapjoin::store {

static_assert(std::endian::native == std::endian::little, "numbers are stored as they lie in memory");

// One `fields` per type: hands every number of the record to `f`, by reference, in the order of the file.

template <typename F>
void fields(PoseId& id, const F& f) {
  f(id.session);
  f(id.key);
}
template <typename F>
void fields(FeatureId& id, const F& f) {
  f(id.key);
}
template <typename F>
void fields(Segment& segment, const F& f) {
  auto is_map = static_cast<std::uint8_t>(segment.is_map);
  f(segment.begin);
  f(segment.end);
  f(is_map);
  segment.is_map = is_map != 0;
}
template <typename Number, typename F>
requires std::is_arithmetic_v<Number>
void fields(Number& number, const F& f) {
  f(number);
}
template <typename Tag, typename F>
void fields(StrongIndex<Tag>& index, const F& f) {
  f(index.value);
}
template <int Rows, int Cols, typename F>
void fields(Matrix<Rows, Cols>& matrix, const F& f) {
  for (int entry = 0; entry < Rows * Cols; ++entry) f(matrix.data()[entry]);
}
template <typename F>
void fields(Rotation<2>& rotation, const F& f) {
  double angle = rotation.angle();
  f(angle);
  rotation = Rotation<2>(angle);
}
template <typename F>
void fields(Rotation<3>& rotation, const F& f) {
  Vector<4> xyzw = rotation.quaternion().coeffs();
  fields(xyzw, f);
  rotation = Rotation<3>(Eigen::Quaterniond(xyzw));
}
template <int Dim, typename F>
void fields(Pose<Dim>& pose, const F& f) {
  fields(pose.translation, f);
  fields(pose.rotation, f);
}
template <typename Observation, typename F>
requires requires(Observation observation) {
  observation.information;
}
void fields(Observation& observation, const F& f) {
  f(observation.base);
  f(observation.target);
  fields(observation.measured, f);
  fields(observation.information, f);
}
template <int Dim, typename F>
void fields(FixedPose<Dim>& fixed, const F& f) {
  f(fixed.pose);
  fields(fixed.value, f);
}

/// Bytes of one record.
template <typename Record>
std::size_t record_size() {
  std::size_t size = 0;
  Record record{};
  fields(record, [&](const auto& number) { size += sizeof number; });
  return size;
}

template <typename Records>
std::string encode_all(const Records& records) {
  std::string bytes;
  bytes.reserve(records.size() * record_size<typename Records::value_type>());
  for (auto record : records) {
    fields(record, [&](const auto& number) { bytes.append(reinterpret_cast<const char*>(&number), sizeof number); });
  }
  return bytes;
}

/// Appends the records in `bytes`; false if these are not whole records.
template <typename Record>
bool decode_all(std::string_view bytes, std::vector<Record>& records) {
  const std::size_t size = record_size<Record>();
  if (bytes.size() % size != 0) return false;
  const char* at = bytes.data();
  for (std::size_t i = 0; i < bytes.size() / size; ++i) {
    fields(records.emplace_back(), [&](auto& number) {
      std::memcpy(&number, at, sizeof number);
      at += sizeof number;
    });
  }
  return true;
}

/// The bytes of the upper triangle of a symmetric matrix, column by column.
inline std::string encode_upper(const Eigen::MatrixXd& matrix) {
  std::string bytes;
  for (Eigen::Index col = 0; col < matrix.cols(); ++col) {
    bytes.append(reinterpret_cast<const char*>(matrix.col(col).data()), static_cast<std::size_t>(col + 1) * sizeof(double));
  }
  return bytes;
}

/// The symmetric matrix that encode_upper() encoded; nullopt if the size is wrong.
inline std::optional<Eigen::MatrixXd> decode_upper(std::string_view bytes, Eigen::Index rows) {
  if (bytes.size() != static_cast<std::size_t>(rows * (rows + 1) / 2) * sizeof(double)) return std::nullopt;
  Eigen::MatrixXd matrix(rows, rows);
  for (Eigen::Index col = 0; col < rows; ++col) {
    const std::size_t size = static_cast<std::size_t>(col + 1) * sizeof(double);
    std::memcpy(matrix.col(col).data(), bytes.data(), size);
    bytes.remove_prefix(size);
  }
  matrix.triangularView<Eigen::StrictlyLower>() = matrix.transpose();
  return matrix;
}

}  // namespace mapjoin::store
