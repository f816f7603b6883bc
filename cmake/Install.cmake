# What is installed: program, library, headers with the generated ones, CMake package, pkg-config file, case files the
# scripts that draw, manual page and completion. The tree can be moved: no file in it names the prefix.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS stiffront_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/stiffront ${PROJECT_BINARY_DIR}/generated/stiffront
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN *.hpp)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/drivers/cases
  DESTINATION ${CMAKE_INSTALL_DATADIR}/stiffront FILES_MATCHING PATTERN *.toml)
install(PROGRAMS ${PROJECT_SOURCE_DIR}/drivers/plot/plot.py ${PROJECT_SOURCE_DIR}/drivers/plot/report.py
  DESTINATION ${CMAKE_INSTALL_DATADIR}/stiffront/plot)
install(FILES ${PROJECT_SOURCE_DIR}/drivers/plot/report.css ${PROJECT_SOURCE_DIR}/drivers/plot/report.js
  DESTINATION ${CMAKE_INSTALL_DATADIR}/stiffront/plot)
install(PROGRAMS ${PROJECT_SOURCE_DIR}/packaging/slurm/stiffront.sbatch DESTINATION ${CMAKE_INSTALL_DATADIR}/stiffront/slurm)
install(FILES ${PROJECT_SOURCE_DIR}/packaging/stiffront.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${PROJECT_SOURCE_DIR}/packaging/completion/stiffront DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR})

# The library is static, so what it uses privately must still be found and linked by whoever links it.
set_target_properties(stiffront_hdf5 PROPERTIES EXPORT_NAME hdf5)
set_target_properties(stiffront_toml PROPERTIES EXPORT_NAME toml)
install(TARGETS stiffront stiffront_hdf5 stiffront_toml EXPORT stiffront ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/stiffront)
install(EXPORT stiffront NAMESPACE stiffront:: FILE stiffrontTargets.cmake DESTINATION ${package_folder})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/stiffrontConfig.cmake.in
  ${PROJECT_BINARY_DIR}/stiffrontConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/stiffrontConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/stiffrontConfig.cmake ${PROJECT_BINARY_DIR}/stiffrontConfigVersion.cmake
  DESTINATION ${package_folder})

# Debian's SUNDIALS has no pkg-config file; the names of its libraries are those of its targets.
get_target_property(link_libraries stiffront LINK_LIBRARIES)
list(FILTER link_libraries INCLUDE REGEX "^SUNDIALS::")
list(TRANSFORM link_libraries REPLACE "^SUNDIALS::" "-lsundials_")
list(JOIN link_libraries " " PC_SUNDIALS)
get_target_property(compile_options stiffront INTERFACE_COMPILE_OPTIONS)
get_target_property(compile_definitions stiffront INTERFACE_COMPILE_DEFINITIONS)
list(TRANSFORM compile_definitions PREPEND "-D")
list(JOIN compile_options " " PC_OPTIONS)
list(JOIN compile_definitions " " PC_DEFINITIONS)
set(PC_LINK_OPTIONS "")
if(STIFFRONT_SANITIZE)
  set(PC_LINK_OPTIONS "-fsanitize=${STIFFRONT_SANITIZE}")
endif()
file(RELATIVE_PATH PC_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(${PROJECT_SOURCE_DIR}/cmake/stiffront.pc.in ${PROJECT_BINARY_DIR}/stiffront.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/stiffront.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

# cpack --preset package: a .deb for any x86-64 machine.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME stiffront)
set(CPACK_PACKAGE_CONTACT "The Stiffront authors")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS openmpi-bin)  # Open MPI starts a helper of its own, for one process too
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-h5py, python3-matplotlib")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
  "g++, cmake, pkg-config, libopenmpi-dev, libhdf5-openmpi-dev, libsundials-dev, libtomlplusplus-dev, libfmt-dev")
include(CPack)
