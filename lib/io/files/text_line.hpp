// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A line of a text output: words separated by one character, numbers with the fewest digits that read back as the same bits.

#include <charconv>
#include <concepts>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/geometry/upper_triangle.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin {

/// The names of the first `count` coordinates of a step of a pose; those of a feature are the first Dim.
template <int Dim>
std::vector<std::string> step_names(std::size_t count = kPoseDof<Dim>) {
  std::vector<std::string> names = {"x", "y", "phi"};
  if constexpr (Dim == 3) names = {"x", "y", "z", "rx", "ry", "rz"};
  names.resize(count);
  return names;
}

class TextLine {
 public:
  explicit TextLine(char separator) : separator_(separator) {}

  TextLine& add(std::string_view word) {
    if (!line_.empty()) line_ += separator_;
    line_ += word;
    return *this;
  }
  /// Adds an integer or a double, whatever the locale.
  template <typename Number>
  requires std::integral<Number> || std::floating_point<Number> TextLine& add(Number number) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, number).ptr;
    return add(std::string_view(digits, static_cast<std::size_t>(end - digits)));
  }
  template <int Size>
  TextLine& add(const Vector<Size>& v) {
    for (int i = 0; i < Size; ++i) add(v[i]);
    return *this;
  }
  /// Adds `x y φ`, or `x y z qx qy qz qw`.
  TextLine& add(const Pose<2>& pose) { return add<2>(pose.translation).add(pose.rotation.angle()); }
  TextLine& add(const Pose<3>& pose) { return add<3>(pose.translation).add<4>(pose.rotation.quaternion().coeffs()); }
  /// Adds `cov_x_x`, `cov_x_y`, …: the names of the columns of add_symmetric().
  TextLine& add_covariance_names(const std::vector<std::string>& coordinates) {
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      for (std::size_t j = i; j < coordinates.size(); ++j) add("cov_" + coordinates[i] + '_' + coordinates[j]);
    }
    return *this;
  }
  /// Adds the upper triangle of a symmetric matrix, row by row.
  template <int Size>
  TextLine& add_symmetric(const Matrix<Size>& M) {
    each_of_upper_triangle(M, [&](double entry) { add(entry); });
    return *this;
  }

  /// Appends the line with its end to a text, and starts over with an empty one.
  void append_to(std::string& text) {
    text += line_;
    text += '\n';
    line_.clear();
  }
  /// Writes the line with its end and starts over with an empty one.
  void write_to(OutputFile& file) {
    line_ += '\n';
    file.write(line_);
    line_.clear();
  }

 private:
  char separator_;
  std::string line_;
};

}  // namespace mapjoin
