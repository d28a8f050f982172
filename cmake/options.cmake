# SPDX-License-Identifier: BSD-3-Clause
# Options of the build, and the flags of our own targets (never of what is installed).
option(MAPJOIN_WERROR "Warnings are errors" OFF)
option(BUILD_SHARED_LIBS "Shared libraries instead of static ones" OFF)
option(MAPJOIN_BENCH "Build the benchmarks" OFF)
set(MAPJOIN_MPI AUTO CACHE STRING "Build mapjoin-mpi, over MPI with MUMPS: AUTO (where both are found, without sanitizers), ON or OFF")
option(MAPJOIN_FUZZ "Build the fuzz targets for libFuzzer (clang)" OFF)
set(MAPJOIN_SANITIZE "" CACHE STRING "Sanitizers, e.g. address,undefined or thread")

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(BUILD_SHARED_LIBS)
  set(CMAKE_INSTALL_RPATH $ORIGIN/../${CMAKE_INSTALL_LIBDIR})
endif()

function(mapjoin_flags target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion)
  # No fused multiply-adds of the compiler's choice: results do not depend on whether the machine has them.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  # In a unity build g++ takes the unnamed namespace of a source for that of a header, and warns.
  target_compile_options(${target} PRIVATE
    $<$<AND:$<CXX_COMPILER_ID:GNU>,$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>>:-Wno-subobject-linkage>)
  if(MAPJOIN_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(MAPJOIN_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${MAPJOIN_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
      $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)  # false warnings with sanitizers, by GCC's manual
    target_link_options(${target} PUBLIC -fsanitize=${MAPJOIN_SANITIZE})
  endif()
endfunction()
