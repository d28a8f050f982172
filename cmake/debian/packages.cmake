# SPDX-License-Identifier: BSD-3-Clause
# Debian packages by `cpack` or `./dev package`: mapjoin (the command), libmapjoin-dev (headers, static libraries, and the packages for
# CMake and pkg-config) and, if MPI and MUMPS are found, mapjoin-mpi.
set(MAPJOIN_MAINTAINER "The mapjoin authors <maintainers@mapjoin.invalid>" CACHE STRING "Who answers for the Debian packages")
set(debian ${CMAKE_CURRENT_LIST_DIR})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME mapjoin)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "large maps from many small ones by submap joining")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(components command development)
if(MAPJOIN_WITH_MPI)
  list(APPEND components mpi)
endif()
set(CPACK_COMPONENTS_ALL ${components})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER ${MAPJOIN_MAINTAINER})
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_COMMAND_PACKAGE_NAME mapjoin)
set(CPACK_DEBIAN_COMMAND_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COMMAND_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COMMAND_DESCRIPTION "mapjoin takes a robot's log (odometry, loop closures, observations of point
features, in the plane or in space), splits it into short local maps, solves
each by least squares, joins them along a tree, and polishes the result to an
optimum of the whole log: full SLAM, without an initial guess.

Debian's CHOLMOD, which it is linked with, holds parts under the GPL.")

# Dependencies: Eigen and tl::expected of the headers, the others of the static libraries.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libmapjoin-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libeigen3-dev (>= 3.4), libexpected-dev, libboost-dev (>= 1.74), libfmt-dev, libgeographiclib-dev, libmetis-dev, libopenblas-dev | liblapack-dev, libsqlite3-dev, libsuitesparse-dev, libtbb-dev, zlib1g-dev")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS mapjoin)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "mapjoin splits a robot's log into short local maps, solves each by least
squares, joins them along a tree, and polishes the result to an optimum of the
whole log. This package holds the C++20 headers, the static libraries, and the
packages for CMake and pkg-config.")

set(CPACK_DEBIAN_MPI_PACKAGE_NAME mapjoin-mpi)
set(CPACK_DEBIAN_MPI_PACKAGE_SECTION science)
set(CPACK_DEBIAN_MPI_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS openmpi-bin)
set(CPACK_DEBIAN_MPI_PACKAGE_SUGGESTS mapjoin)
set(CPACK_DEBIAN_MPI_DESCRIPTION "mapjoin splits a robot's log into short local maps, solves each by least
squares, joins them along a tree, and polishes the result to an optimum of the
whole log. This package holds the command that does so on several machines at
once, over MPI: each has a region of the map, and what regions share is solved
by MUMPS.")

# Licence and changes of each package; `cmake --install` leaves them out.
string(TIMESTAMP release_date "%a, %d %b %Y %H:%M:%S +0000" UTC)
configure_file(${debian}/changelog.in ${CMAKE_CURRENT_BINARY_DIR}/debian/changelog.Debian @ONLY)
configure_file(CHANGELOG.md ${CMAKE_CURRENT_BINARY_DIR}/debian/changelog COPYONLY)
foreach(file changelog.Debian changelog)
  execute_process(COMMAND ${GZIP} -9nf ${file} WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/debian COMMAND_ERROR_IS_FATAL ANY)
endforeach()
foreach(component ${components})
  string(TOUPPER ${component} id)
  install(
    FILES ${debian}/copyright ${CMAKE_CURRENT_BINARY_DIR}/debian/changelog.Debian.gz ${CMAKE_CURRENT_BINARY_DIR}/debian/changelog.gz
    DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${CPACK_DEBIAN_${id}_PACKAGE_NAME} COMPONENT ${component} EXCLUDE_FROM_ALL)
endforeach()

# Completion in the folder of Debian's zsh.
install(FILES apps/manual/_mapjoin DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/zsh/vendor-completions
  COMPONENT command EXCLUDE_FROM_ALL)

include(CPack)
