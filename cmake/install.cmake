# SPDX-License-Identifier: BSD-3-Clause
# Installation of the command, with its documents and logs to try; of mapjoin-mpi; and of what programs are built with: libraries,
# headers, and the packages that find_package(mapjoin) and pkg-config find.
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/mapjoin)
set(header_folder ${CMAKE_INSTALL_INCLUDEDIR}/mapjoin)

install(TARGETS mapjoin COMPONENT command)
install(FILES README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT command)
install(DIRECTORY docs data DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT command PATTERN Doxyfile EXCLUDE
  PATTERN CMakeLists.txt EXCLUDE PATTERN cases EXCLUDE)

install(DIRECTORY ${MAPJOIN_MANUAL}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT command FILES_MATCHING PATTERN *.gz)
install(FILES apps/manual/completion.bash RENAME mapjoin DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions
  COMPONENT command)
install(FILES apps/manual/_mapjoin DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/zsh/site-functions COMPONENT site)

if(MAPJOIN_WITH_MPI)
  install(TARGETS mapjoin_mpi COMPONENT mpi)
  install(FILES ${CMAKE_BINARY_DIR}/manual-mpi/mapjoin-mpi.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT mpi)
  if(BUILD_SHARED_LIBS)
    install(TARGETS mapjoin_distributed COMPONENT mpi)
  endif()
endif()

install(TARGETS mapjoin_core mapjoin_localmap mapjoin_join EXPORT mapjoin-targets COMPONENT development)
install(EXPORT mapjoin-targets NAMESPACE mapjoin:: DESTINATION ${package_folder} COMPONENT development)
install(DIRECTORY lib/ DESTINATION ${header_folder} COMPONENT development FILES_MATCHING PATTERN *.hpp)
install(DIRECTORY localmap join DESTINATION ${header_folder} COMPONENT development FILES_MATCHING PATTERN *.hpp
  PATTERN distributed EXCLUDE)
install(FILES ${CMAKE_BINARY_DIR}/include/mapjoin/version.hpp DESTINATION ${header_folder} COMPONENT development)

configure_package_config_file(cmake/mapjoin-config.cmake.in mapjoin-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(mapjoin-config-version.cmake COMPATIBILITY SameMinorVersion)
install(
  FILES ${CMAKE_CURRENT_BINARY_DIR}/mapjoin-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/mapjoin-config-version.cmake
        cmake/find_library_by_header.cmake
  DESTINATION ${package_folder} COMPONENT development)

# mapjoin.pc takes its prefix from its own place. Users of static libraries link the libraries that these need.
file(RELATIVE_PATH prefix_of_pc /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
if(NOT BUILD_SHARED_LIBS)
  set(pc_requires fmt tbb sqlite3 zlib lapack blas)
  set(pc_libs -lGeographicLib -lmetis -lcholmod -lcamd -lamd)
endif()
list(JOIN pc_requires " " pc_requires)
list(JOIN pc_libs " " pc_libs)
configure_file(cmake/mapjoin.pc.in mapjoin.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/mapjoin.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
