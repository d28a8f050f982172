// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One local map of the original authors, as its MAT or Linear SLAM text file gives it: a state and its Gaussian.

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace mapjoin {

/// A local map as a state and its Gaussian. The rows of the state are the end pose (x, y, φ, or x, y, z, a, b, c with R = Rz(a)
/// Ry(b) Rx(c)), then each feature's position, all in the frame of the start pose (m, rad).
struct LocalMapFile {
  std::filesystem::path path;
  std::int64_t number = 0;   ///< From the file's name; the map goes from pose number - 1 to pose number.
  Eigen::MatrixX2d state;    ///< Id and value; the end pose's id is 0 or -number.
  Eigen::MatrixXd gaussian;  ///< Covariance or information matrix over the state's rows.
  bool is_information = false;
};

/// The k of a file name localmap_<k>.mat or localmap_<k>.txt, with or without .gz; nullopt for other names.
std::optional<std::int64_t> local_map_number(const std::string& file_name);

/// True if a folder has files with such names.
bool has_local_maps(const std::filesystem::path& folder);

/// The map in the file `path` with the content `bytes`: MAT with `localmap_st` and `localmap_P` (covariance) or with `st`, `I`
/// (information) and `Ref`; text with the index of the start pose, the number n of rows, n lines `id value`, and the n × n
/// information matrix. Errors name file and line, or variable; read_local_map_set() checks the state and the Gaussian.
Expected<LocalMapFile> parse_local_map(const std::filesystem::path& path, std::string_view bytes);

}  // namespace mapjoin
