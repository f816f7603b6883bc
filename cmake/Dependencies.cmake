# Every dependency is a Debian 12 package (cmake/debian-packages.txt).
find_package(PkgConfig REQUIRED)
find_package(MPI REQUIRED COMPONENTS C)
find_package(fmt REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(SUNDIALS REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)

# Parallel HDF5 by pkg-config: find_package(HDF5) would prefer whichever h5cc comes first on the path.
pkg_check_modules(HDF5_OPENMPI REQUIRED IMPORTED_TARGET hdf5-openmpi)
add_library(stiffront_hdf5 INTERFACE)
target_link_libraries(stiffront_hdf5 INTERFACE PkgConfig::HDF5_OPENMPI)

# The pkg-config file, unlike the CMake target, selects toml++'s shared library (0.9 s a file against 4.1 s).
pkg_check_modules(TOMLPLUSPLUS REQUIRED IMPORTED_TARGET tomlplusplus)
add_library(stiffront_toml INTERFACE)
target_link_libraries(stiffront_toml INTERFACE PkgConfig::TOMLPLUSPLUS)
