// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Local-map sets of the original authors: localmap_1, localmap_2, ... as MAT or Linear SLAM text files in a folder or an
// archive; read, and written.

#include <filesystem>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin {

/// The files decide which.
using AnySubmapSet = std::variant<SubmapSet<2>, SubmapSet<3>>;

/// The maps localmap_<k>.mat or localmap_<k>.txt (either with .gz) of a folder or of a .tar or .tar.gz archive, k = 1, 2, ...
/// in the order of their numbers. Map k goes from pose k-1 to pose k; those are the poses' keys. Where a map's end pose is its
/// start pose, exactly (zero motion of zero covariance), they are one pose under the name of the start, and the map observes
/// features only. In 3D the Gaussian over the file's three angles is turned to the rotation vector at the end pose of the map.
/// A missing number, a number given twice, maps of both dimensions, a state that is not an end pose and features, each once,
/// and a Gaussian that is not finite, symmetric and, a covariance, positive definite or, an information matrix, positive
/// semidefinite (see InformationCheck) are errors.
Expected<AnySubmapSet> read_local_map_set(const std::filesystem::path& folder_or_archive, const ReadOptions& options = {});

enum class LocalMapFormat {
  kMat,   ///< In the plane `localmap_st` and `localmap_P` (covariance), in space `st`, `I` (information) and `Ref`.
  kText,  ///< Linear SLAM's, with information matrices.
};

/// Writes map k of `maps` as `localmap_<k>.mat` or `.txt` into a folder that is there; the names, in their order. Map k goes
/// from pose k - 1 to pose k, whatever they were called. What is written reads back (see read_local_map_set()) as the same bits
/// in the plane as text; covariances are inverses, and in space angles and their weights are rounded. kUsage where the maps are
/// not a chain, each from the end pose of the one before it to one pose; where an id is 2^53 or more; where a covariance does
/// not exist; where a map does not move, but for MAT files in the plane; at a pitch of a right angle. kCannotWrite, after which
/// some of the files may be there.
template <int Dim>
Expected<std::vector<std::string>> write_local_maps(const std::vector<LocalMap<Dim>>& maps, const FeatureIds& features,
                                                    LocalMapFormat format, const std::filesystem::path& folder);

}  // namespace mapjoin
