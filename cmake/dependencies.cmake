# SPDX-License-Identifier: BSD-3-Clause
# The libraries we stand on; all are Debian packages (`./dev deps`).
include(${CMAKE_CURRENT_LIST_DIR}/find_library_by_header.cmake)

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(tl-expected REQUIRED)
find_package(fmt REQUIRED)
find_package(TBB REQUIRED)
find_package(Boost 1.74 REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(nanoflann REQUIRED)
find_package(ZLIB REQUIRED)
find_package(LAPACK REQUIRED)
find_library_by_header(mapjoin::geographic HEADER GeographicLib/LocalCartesian.hpp LIBRARIES GeographicLib)
find_library_by_header(mapjoin::metis HEADER metis.h LIBRARIES metis)
find_library_by_header(mapjoin::suitesparse HEADER suitesparse/cholmod.h LIBRARIES cholmod camd amd)
