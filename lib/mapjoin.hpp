// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The main header of the library: logs from files or memory, local maps, their join, all at once or one by one, and
// covariances.

// Poses, names, measurements, maps, and errors as values.
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/model/submap_set.hpp>

// Files: open_log() and open_maps(); writers of logs, maps and stores.
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/io/store/store.hpp>

// Joining a log: run() and solve(); split() and build_local_maps() for the local maps alone.
#include <mapjoin/join/run.hpp>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/localmap/split.hpp>

// Incremental joining, map by map, and covariances of the joined map.
#include <mapjoin/join/covariances/map_covariances.hpp>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/join/incremental/submap_update_maker.hpp>

// Data association: which features are the same if they have no names, or none that are trusted.
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/association/associate_in_doubt.hpp>

// Checks of logs and sets of local maps, outlier rejection, at once or map by map, and errors against the truth.
#include <mapjoin/check/checks.hpp>
#include <mapjoin/join/incremental/robust_incremental_join.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/measure/trajectory_error.hpp>

// GPS fixes as priors of the map, and the outliers among them.
#include <mapjoin/gps/fixes.hpp>
#include <mapjoin/io/formats/gps_csv.hpp>
#include <mapjoin/join/robust/fix_inliers.hpp>

#include <mapjoin/version.hpp>
