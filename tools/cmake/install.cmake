# The installed tree: headers under include/scree, a CMake package with scree::scree, and scree.pc.
set(SCREE_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/scree)

install(TARGETS scree EXPORT scree-targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(SCREE_MPI)
  # Apart from the others: programs that use no MPI find the package where there is none.
  install(EXPORT scree-mpi-targets NAMESPACE scree:: DESTINATION ${SCREE_PACKAGE_DIR})
  install(TARGETS scree_mpi EXPORT scree-mpi-targets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY parallel/mpi/include/scree DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
endif()
install(DIRECTORY core/include/scree parallel/include/scree DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.h")
install(EXPORT scree-targets NAMESPACE scree:: DESTINATION ${SCREE_PACKAGE_DIR})

if(BUILD_SHARED_LIBS)
  set(SCREE_STATIC OFF)
  set(SCREE_PC_REQUIRES "Requires.private: tbb qhull_r libzstd")
  set(SCREE_PC_CFLAGS "-DSCREE_SHARED")
else()
  set(SCREE_STATIC ON)
  set(SCREE_PC_REQUIRES "Requires: tbb qhull_r libzstd")
  set(SCREE_PC_CFLAGS "")
endif()
configure_package_config_file(tools/cmake/scree-config.cmake.in scree-config.cmake
  INSTALL_DESTINATION ${SCREE_PACKAGE_DIR})
# Before version 1 the interface may change with every minor version.
write_basic_package_version_file(scree-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/scree-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/scree-config-version.cmake
  DESTINATION ${SCREE_PACKAGE_DIR})

# Relative to the file itself, so that the installed tree can be moved.
file(RELATIVE_PATH SCREE_PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" SCREE_PC_PREFIX "${SCREE_PC_PREFIX}")
configure_file(tools/cmake/scree.pc.in scree.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/scree.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
