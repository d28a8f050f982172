# SPDX-License-Identifier: BSD-3-Clause
# What is installed beside the command: libraries, headers, and the package that find_package(mapjoin) finds.
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/mapjoin)
set(header_folder ${CMAKE_INSTALL_INCLUDEDIR}/mapjoin)

install(TARGETS mapjoin_core mapjoin_localmap mapjoin_join EXPORT mapjoin-targets)
install(EXPORT mapjoin-targets NAMESPACE mapjoin:: DESTINATION ${package_folder})

install(DIRECTORY lib/ DESTINATION ${header_folder} FILES_MATCHING PATTERN *.hpp)
install(DIRECTORY localmap join DESTINATION ${header_folder} FILES_MATCHING PATTERN *.hpp)
install(FILES ${CMAKE_BINARY_DIR}/include/mapjoin/version.hpp DESTINATION ${header_folder})

configure_package_config_file(cmake/mapjoin-config.cmake.in mapjoin-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(mapjoin-config-version.cmake COMPATIBILITY SameMinorVersion)
install(
  FILES ${CMAKE_CURRENT_BINARY_DIR}/mapjoin-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/mapjoin-config-version.cmake
        cmake/find_library_by_header.cmake
  DESTINATION ${package_folder})
