// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The door to the library: logs from files or from memory, local maps, their join, at once or one by one, and covariances.

// Poses, names, measurements, maps, and errors as values.
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/model/submap_set.hpp>

// Files: open_log(), open_maps(); logs, maps and stores written.
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/io/store/store.hpp>

// From a log to a map: run(), solve(); split() and build_local_maps() for its first half alone.
#include <mapjoin/join/run.hpp>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/localmap/split.hpp>

// Map by map, and how certain a map is.
#include <mapjoin/join/covariances/map_covariances.hpp>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/join/incremental/submap_update_maker.hpp>

// Which features are the same, where they have no names, or none that are trusted.
#include <mapjoin/join/association/associate.hpp>

// Fixes of a satellite receiver that hold the map, and which of them are wrong.
#include <mapjoin/gps/fixes.hpp>
#include <mapjoin/io/formats/gps_csv.hpp>
#include <mapjoin/join/robust/fix_inliers.hpp>

// What could be wrong with a log, and how far a map is from the truth.
#include <mapjoin/check/checks.hpp>
#include <mapjoin/measure/trajectory_error.hpp>

#include <mapjoin/version.hpp>
