# SPDX-License-Identifier: BSD-3-Clause
configure_file(cmake/version.hpp.in include/mapjoin/version.hpp)

# A library mapjoin_NAME of the sources in one folder. Headers are included as <mapjoin/room/file.hpp>, in the build tree (through
# links) as when installed.
function(mapjoin_library name)
  cmake_parse_arguments(ARG "" "FOLDER" "" ${ARGN})
  set(headers ${CMAKE_BINARY_DIR}/include/mapjoin)
  file(MAKE_DIRECTORY ${headers})
  if(name STREQUAL "core")
    file(GLOB rooms CONFIGURE_DEPENDS LIST_DIRECTORIES true RELATIVE ${CMAKE_SOURCE_DIR}/lib ${CMAKE_SOURCE_DIR}/lib/*)
    foreach(room ${rooms})
      file(CREATE_LINK ${CMAKE_SOURCE_DIR}/lib/${room} ${headers}/${room} SYMBOLIC)
    endforeach()
  else()
    file(CREATE_LINK ${CMAKE_SOURCE_DIR}/${ARG_FOLDER} ${headers}/${name} SYMBOLIC)
  endif()

  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${ARG_FOLDER}/*.cpp)
  # Sources of join/distributed, which needs MPI, are a library of their own.
  list(FILTER sources EXCLUDE REGEX "^${CMAKE_SOURCE_DIR}/${ARG_FOLDER}/distributed/")
  add_library(mapjoin_${name} ${sources})
  add_library(mapjoin::${name} ALIAS mapjoin_${name})
  set_target_properties(mapjoin_${name} PROPERTIES
    EXPORT_NAME ${name} VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_compile_features(mapjoin_${name} PUBLIC cxx_std_20)
  target_include_directories(mapjoin_${name} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  mapjoin_flags(mapjoin_${name})
  target_precompile_headers(mapjoin_${name} PRIVATE ${CMAKE_SOURCE_DIR}/cmake/precompiled.hpp)
endfunction()
