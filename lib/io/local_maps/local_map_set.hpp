// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Local-map sets of the original authors: localmap_1, localmap_2, ... as MAT or Linear SLAM text files, read from a folder or
// an archive, and written into a folder.

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

/// A set of local maps, in the dimension of its files.
using AnySubmapSet = std::variant<SubmapSet<2>, SubmapSet<3>>;

/// The maps localmap_<k>.mat or localmap_<k>.txt, numbered k = 1, 2, ..., also with .gz, of a folder or of a .tar or .tar.gz
/// archive, in the order of their numbers. Map k goes from pose k-1 to pose k; those are the poses' keys. If a map's
/// end pose is exactly its start pose (zero motion of zero covariance), they are one pose under the name of the start, and the
/// map observes features only. In 3D the Gaussian over the file's three angles is turned to the rotation vector at the end pose
/// of the map. Bad input: a missing number, a number given twice, maps of both dimensions, a state that is not an end pose and
/// features, each once, and a Gaussian that is not finite, symmetric and, if a covariance, positive definite or, if an
/// information matrix, positive semidefinite (see InformationCheck).
Expected<AnySubmapSet> read_local_map_set(const std::filesystem::path& folder_or_archive, const ReadOptions& options = {});

enum class LocalMapFormat {
  kMat,   ///< In the plane `localmap_st` and `localmap_P` (covariance), in space `st`, `I` (information) and `Ref`.
  kText,  ///< Linear SLAM's text, with information matrices.
};

/// Writes map k of `maps` as `localmap_<k>.mat` or `.txt` into an existing folder; the names, in their order. Map k goes from
/// pose k-1 to pose k, whatever these were called. Planar maps as text read back (see read_local_map_set()) as the same bits;
/// covariances are inverses, and in space angles and their weights are rounded. kUsage if the maps are not a chain, each from
/// the end pose of the one before it to one pose; if a feature's id is 2^53 or more; if a covariance does not exist; if a map
/// does not move, except in planar MAT files; at a pitch of a right angle. kTooLarge for a matrix of 2 GiB or more in a MAT
/// file. kCannotWrite, after which some of the files may be there.
template <int Dim>
Expected<std::vector<std::string>> write_local_maps(const std::vector<LocalMap<Dim>>& maps, const FeatureIds& features,
                                                    LocalMapFormat format, const std::filesystem::path& folder);

}  // namespace mapjoin
