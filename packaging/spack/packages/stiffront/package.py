# SPDX-License-Identifier: BSD-3-Clause
from spack.package import *


class Stiffront(CMakePackage):
    """MPI-parallel solver for stiff reaction-diffusion equations: adaptive operator splitting, deferred
    correction, results with the same bits on any number of ranks.

    Builds a working copy: spack repo add packaging/spack && spack dev-build -d . stiffront@main"""

    license("BSD-3-Clause")

    version("main")

    variant("native", default=True, description="Compile for the processor of the building machine")
    variant("plots", default=True, description="Python with h5py and matplotlib for 'stiffront plot'")

    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mpi@3.1:")
    depends_on("hdf5@1.10:+mpi")
    depends_on("sundials@6.4:6+CVODE+int64")
    depends_on("eigen@3.4:3")
    depends_on("tomlplusplus@3.3:")
    depends_on("fmt@9:")
    depends_on("cli11@2.1:")
    depends_on("nlohmann-json@3.11:")
    depends_on("googletest@1.12:", type="test")
    depends_on("python@3.9:", when="+plots", type="run")
    depends_on("py-h5py", when="+plots", type="run")
    depends_on("py-matplotlib", when="+plots", type="run")

    conflicts("%gcc@:11", msg="needs the C++20 of g++ 12")

    generator("ninja")

    def setup_build_environment(self, env):
        # The build asks pkg-config for Debian's name of parallel HDF5.
        folder = join_path(self.stage.path, "pkgconfig")
        mkdirp(folder)
        hdf5 = self.spec["hdf5"]
        with open(join_path(folder, "hdf5-openmpi.pc"), "w") as pc:
            pc.write("Name: HDF5\nDescription: parallel HDF5\n")
            pc.write(f"Version: {hdf5.version}\n")
            pc.write(f"Cflags: -I{hdf5.prefix.include}\nLibs: {hdf5.libs.ld_flags}\n")
        env.prepend_path("PKG_CONFIG_PATH", folder)

    def cmake_args(self):
        return [
            self.define_from_variant("STIFFRONT_NATIVE", "native"),
            self.define("STIFFRONT_TESTS", self.run_tests),
        ]
