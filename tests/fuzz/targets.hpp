// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The fuzz targets: a function over any bytes for every reader, which throws if the reader breaks a promise.

#include <string_view>

namespace mapjoin::fuzz {

// Texts of logs. For all but the last two, a first line `#OP`, a comment to the readers, chooses their options: see
// choices.hpp.
void g2o(std::string_view bytes);
void growing_g2o(std::string_view bytes);
void toro(std::string_view bytes);
void isam(std::string_view bytes);
void gtsam_text(std::string_view bytes);
void covariance_text(std::string_view bytes);
void trajectory(std::string_view bytes);
// Tables.
void pose_csv(std::string_view bytes);
void stamps(std::string_view bytes);
void gps_csv(std::string_view bytes);
// Several files in one input: see folder.hpp.
void mrclam(std::string_view bytes);
void local_map_folder(std::string_view bytes);
// Single local maps, named localmap_1.
void local_map_text(std::string_view bytes);
void local_map_mat(std::string_view bytes);
// Logs as MAT files.
void mat_log(std::string_view bytes);
// Files as they are; any_log() takes its options from a first line `#OP`.
void gzip(std::string_view bytes);
void archive(std::string_view bytes);
void store(std::string_view bytes);
void any_log(std::string_view bytes);

struct Target {
  std::string_view name;
  void (*run)(std::string_view bytes);
};

inline constexpr Target kTargets[] = {
    {"g2o", g2o},
    {"growing_g2o", growing_g2o},
    {"toro", toro},
    {"isam", isam},
    {"gtsam_text", gtsam_text},
    {"covariance_text", covariance_text},
    {"trajectory", trajectory},
    {"pose_csv", pose_csv},
    {"stamps", stamps},
    {"gps_csv", gps_csv},
    {"mrclam", mrclam},
    {"local_map_folder", local_map_folder},
    {"local_map_text", local_map_text},
    {"local_map_mat", local_map_mat},
    {"mat_log", mat_log},
    {"gzip", gzip},
    {"archive", archive},
    {"store", store},
    {"any_log", any_log},
};

}  // namespace mapjoin::fuzz
