# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""`cmake --preset gl` wants none of the optional libraries, and with VOLUTE_DEPS_DIR nothing but a compiler and CMake.
Configures only. Argument: the source folder."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop(1))
OPTIONAL = ["VTK", "OpenVDB", "NanoVDB", "OpenEXR", "embree", "GTest", "rapidcheck", "zfp", "glfw3", "HDF5"]
NEEDED = ["TBB", "fmt", "Eigen3", "hwy", "ZLIB", "PNG", "nlohmann_json", "CLI11", "tl-expected", "PkgConfig"]
# What the recipes of cmake/VoluteFetched.cmake look for.
FILES = ["include/tl/expected.hpp", "include/fmt/format.h", "include/nlohmann/json.hpp", "include/CLI/CLI.hpp",
         "include/eigen3/Eigen/Core", "highway/hwy/targets.cc", "zlib/zlib.c", "libpng1.6/png.c",
         "libpng1.6/scripts/pnglibconf.h.prebuilt", "libyaml/src/parser.c", "libzstd/lib/common/xxhash.c",
         "libepoxy/src/dispatch_common.c"]
TBB = "add_library(tbb INTERFACE)\nadd_library(TBB::tbb ALIAS tbb)\n"


class BareMachine(unittest.TestCase):
    def configure(self, folder, *options):
        result = subprocess.run(["cmake", "--preset", "gl", "-S", SOURCE, "-B", folder / "build", *options], cwd=SOURCE,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_without_the_optional_libraries(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            # Two of the modules that pkg-config knows are needed; it says of all others that they are not there.
            script = folder / "pkg-config"
            script.write_text('#!/bin/sh\ncase "$*" in\n*libav*|*tinygltf*|*imgui*|*glfw*) exit 1;;\n*) exec pkg-config "$@";;\nesac\n')
            script.chmod(0o755)
            self.configure(folder, f"-DPKG_CONFIG_EXECUTABLE={script}",
                           *[f"-DCMAKE_DISABLE_FIND_PACKAGE_{package}=ON" for package in OPTIONAL])

    def test_with_a_compiler_alone(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            libraries = folder / "libraries"
            for file in FILES:
                (libraries / file).parent.mkdir(parents=True, exist_ok=True)
                (libraries / file).touch()
            (libraries / "onetbb").mkdir()
            (libraries / "onetbb/CMakeLists.txt").write_text(TBB)
            self.configure(folder, f"-DVOLUTE_DEPS_DIR={libraries}",
                           *[f"-DCMAKE_DISABLE_FIND_PACKAGE_{package}=ON" for package in OPTIONAL + NEEDED])


if __name__ == "__main__":
    unittest.main()
