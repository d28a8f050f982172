# SPDX-License-Identifier: BSD-3-Clause
# An imported target for a library without a CMake package, found by the names of a header and of library files. Targets are called
# mapjoin::…, since the find modules of other packages (Ceres, for one) define the usual names.
function(find_library_by_header target)
  cmake_parse_arguments(ARG "" "HEADER;SUFFIX" "LIBRARIES" ${ARGN})
  if(TARGET ${target})
    return()
  endif()
  string(MAKE_C_IDENTIFIER ${target} id)
  find_path(${id}_INCLUDE_DIR ${ARG_HEADER} PATH_SUFFIXES ${ARG_SUFFIX} REQUIRED)
  add_library(${target} INTERFACE IMPORTED)
  target_include_directories(${target} SYSTEM INTERFACE ${${id}_INCLUDE_DIR})
  foreach(library ${ARG_LIBRARIES})
    find_library(${id}_${library}_LIBRARY ${library} REQUIRED)
    target_link_libraries(${target} INTERFACE ${${id}_${library}_LIBRARY})
  endforeach()
endfunction()
