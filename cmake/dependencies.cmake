# SPDX-License-Identifier: BSD-3-Clause
# The libraries we stand on; all are Debian packages (`./dev deps`).
include(${CMAKE_CURRENT_LIST_DIR}/find_library_by_header.cmake)

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(tl-expected REQUIRED)
find_package(fmt REQUIRED)
find_package(TBB REQUIRED)
find_package(Boost 1.74 REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(ZLIB REQUIRED)
# Static where it can be: HDF5's shared library brings some forty others along, and to load them takes longer than to map a small log.
find_library(MAPJOIN_STATIC_HDF5 libhdf5_serial.a)
if(MAPJOIN_STATIC_HDF5 AND NOT BUILD_SHARED_LIBS)
  find_library_by_header(mapjoin::matio HEADER matio.h LIBRARIES libmatio.a libhdf5_serial.a libsz.a libaec.a z)
else()
  find_library_by_header(mapjoin::matio HEADER matio.h LIBRARIES matio)
endif()
find_library_by_header(mapjoin::metis HEADER metis.h LIBRARIES metis)
find_library_by_header(mapjoin::suitesparse HEADER suitesparse/cholmod.h LIBRARIES cholmod camd amd)
# Not linked but loaded when the program runs (lib/solve/blas.hpp). Nothing else here uses it: one that is missing is better found now.
find_library(MAPJOIN_LAPACK NAMES libopenblas.so.0 liblapack.so.3 REQUIRED)
