// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The front door for logs of every format, and for local maps, whoever built them.

#include <filesystem>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/io/merged_logs.hpp>
#include <mapjoin/io/store/store.hpp>
#include <variant>
#include <vector>

namespace mapjoin {

/// The log in a file, recognised by its content rather than its name unless `options` name the format: g2o, TORO, iSAM, GTSAM's
/// text, the text and MAT forms of Victoria Park and of the corrected DLR data, `map.circles`, a TUM or KITTI trajectory, or a
/// table of poses, each also as gzip; or the log in a folder of UTIAS MRCLAM data, or of a run (see read_run_folder()). Bad
/// input: a missing file, another folder, an empty or unreadable file, or one of another format.
Expected<AnyLog> open_log(const std::filesystem::path& path, const ReadOptions& options = {});

/// The logs of several files as one (see merged()): in a file with vertices, edges to poses that it does not declare refer to
/// poses of another file, unless `options` leave them out. Bad input, too, if some are in the plane and others in space; kUsage
/// if one is a copy of another (see check_no_copies()), unless `merging` keeps copies.
Expected<AnyLog> open_logs(const std::vector<std::filesystem::path>& paths, ReadOptions options = {},
                           const MergeOptions& merging = {});

/// Local maps of others, or local maps built from a log together with that log.
using AnyMaps = std::variant<SubmapSet<2>, SubmapSet<3>, StoredMaps<2>, StoredMaps<3>>;

/// True if the path is of a kind that open_maps() takes: a folder with local maps, a tar archive or a store. False for folders
/// of MRCLAM data, and for files of logs.
bool may_hold_maps(const std::filesystem::path& path);

/// The local maps in a folder or a .tar or .tar.gz archive of localmap_<k>.mat or .txt (see read_local_map_set()), or in a
/// mapjoin store of either kind (see read_store() and write_store()), which are told apart by their content. Bad input, too, if
/// a store has only a portion of its log.
Expected<AnyMaps> open_maps(const std::filesystem::path& path, const ReadOptions& options = {});
/// The local maps that open_maps() gives, including a store that has only a portion of its log.
Expected<AnyMaps> open_maps_or_portion(const std::filesystem::path& path, const ReadOptions& options = {});

/// The maps of several stores, or of several sets of others' maps, as one: each is a session (see merged()), tied to the others
/// by shared features. Stores of one log are parts of its maps; segments that no part has as a map are joined as observed. The
/// log in a store and its maps have every feature that was seen, so that the join is that of one log. Portions of a log are put
/// together; all of them must be given. Bad input: stores beside sets, whatever open_maps() refuses, different dimensions or
/// weights, parts that are cut in different ways, and some of the parts of one log beside stores of another. kUsage if one is a
/// copy of another (see check_no_copies()), unless `merging` keeps copies; equal stores of a log are parts of it.
Expected<AnyMaps> open_several_maps(const std::vector<std::filesystem::path>& paths, const ReadOptions& options = {},
                                    const MergeOptions& merging = {});

}  // namespace mapjoin
