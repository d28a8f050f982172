# SPDX-License-Identifier: BSD-3-Clause
# The library that tests and benchmarks share, included as <tests/support/file.hpp>: reference solver, starts, random values.
include_guard(GLOBAL)
find_package(Ceres REQUIRED)

file(GLOB support_sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/support/*.cpp)
list(FILTER support_sources EXCLUDE REGEX _test.cpp$)
add_library(mapjoin_test_support STATIC ${support_sources})
target_include_directories(mapjoin_test_support PUBLIC ${CMAKE_SOURCE_DIR})
target_link_libraries(mapjoin_test_support PUBLIC mapjoin::core PRIVATE Ceres::ceres)
mapjoin_flags(mapjoin_test_support)
# No unity build, so that benchmarks link only objects that need no GoogleTest.
set_target_properties(mapjoin_test_support PROPERTIES UNITY_BUILD OFF)
target_compile_options(mapjoin_test_support PRIVATE $<$<CONFIG:Release>:-O2>)
