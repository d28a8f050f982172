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

/// The log in a file, which is known by its content, not by its name: g2o, TORO, iSAM, GTSAM's text, the text and MAT forms of
/// Victoria Park and of the corrected DLR data, `map.circles`, or a TUM or KITTI trajectory; each also as gzip. Or the log in a
/// folder of UTIAS MRCLAM data. Bad input are a file that is missing, another folder, a file that is empty or unreadable, and
/// one of another format.
Expected<AnyLog> open_log(const std::filesystem::path& path, const ReadOptions& options = {});

/// The logs of several files as one (see merged()): edges of a file with vertices to poses that it does not declare are those
/// of another file, unless `options` leave them out. Bad input, too, where some are in the plane and others in space.
Expected<AnyLog> open_logs(const std::vector<std::filesystem::path>& paths, ReadOptions options = {},
                           const MergeOptions& merging = {});

/// Local maps of others, or those that were built from a log, which come with it.
using AnyMaps = std::variant<SubmapSet<2>, SubmapSet<3>, StoredMaps<2>, StoredMaps<3>>;

/// Whether the path is of a kind that open_maps() takes: a folder, a tar archive or a store. Logs are none of these, but for
/// folders of MRCLAM data.
bool may_hold_maps(const std::filesystem::path& path);

/// The local maps in a folder or a .tar or .tar.gz archive of localmap_<k>.mat or .txt (see read_local_map_set()), or in a
/// mapjoin store of either kind (see read_store() and write_store()), which are told apart by their content. Bad input, too,
/// where a store has but a portion of its log.
Expected<AnyMaps> open_maps(const std::filesystem::path& path, const ReadOptions& options = {});
/// The same, and a portion of a log as it is.
Expected<AnyMaps> open_maps_or_portion(const std::filesystem::path& path, const ReadOptions& options = {});

/// The maps of several stores, or of several sets of others' maps, as those of one: each a session (see merged()), tied by the
/// features that they share; but stores of one log are parts of its maps, and what no part has is joined as it was observed. A
/// store knows its log, and its maps have every feature that was seen, so that the join is that of one log. Portions of a log,
/// which are all to be there, are put together. Bad input: stores beside sets, what open_maps() refuses, other dimensions, and
/// parts that are cut in different ways.
Expected<AnyMaps> open_several_maps(const std::vector<std::filesystem::path>& paths, const ReadOptions& options = {},
                                    const MergeOptions& merging = {});

}  // namespace mapjoin
