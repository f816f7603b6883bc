-- Lmod module file. Set the prefix to where `cmake --install` put the tree, and load what it was built with.
help("Stiffront: MPI-parallel solver for stiff reaction-diffusion equations")
whatis("Name: stiffront")
whatis("Version: 0.1.0")

local prefix = "/opt/stiffront/0.1.0"
depends_on("openmpi", "hdf5", "sundials")

prepend_path("PATH", pathJoin(prefix, "bin"))
prepend_path("CMAKE_PREFIX_PATH", prefix)
prepend_path("PKG_CONFIG_PATH", pathJoin(prefix, "lib", "pkgconfig"))
