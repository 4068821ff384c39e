# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""The part of a wheel's build that pyproject.toml cannot say: CMake makes the extension modules, the command and its plug-ins, which the
wheel has in volute/program. VOLUTE_BUILD names a build folder that is used as it is configured."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = pathlib.Path(__file__).resolve().parent
VERSION = ".".join(re.findall(r"^#define VOLUTE_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)",
                              (HERE.parent / "src/volute/base/version.hpp").read_text(), re.M))


class Cmake(build_ext):
    def run(self):
        build = pathlib.Path(os.environ.get("VOLUTE_BUILD", self.build_temp)).resolve()
        if not (build / "build.ninja").exists():
            subprocess.check_call(["cmake", "-S", HERE.parent, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                                   "-DVOLUTE_TESTS=OFF", "-DVOLUTE_BENCH=OFF", f"-DVOLUTE_PYTHON={sys.executable}"])
        subprocess.check_call(["cmake", "--build", build, "--target", "volute-python", "volute", "volute-plugins"])
        to = HERE / "volute" if self.inplace else pathlib.Path(self.build_lib) / "volute"
        to.mkdir(parents=True, exist_ok=True)
        for name in ["_core", "_scene"]:
            for module in (build / "python/volute").glob(f"{name}.*.so"):
                shutil.copy(module, to)
        if self.inplace:
            return  # the command is found on the path
        parts = [build / "bin/volute", *(build / "lib/volute").glob("volute_io_*.so")]
        for part in (part for part in parts if "hostile" not in part.name):  # that is of the tests
            copied = to / "program" / part.relative_to(build)
            copied.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(part, copied)
            subprocess.check_call(["strip", "--strip-unneeded", copied])


setup(version=VERSION, cmdclass={"build_ext": Cmake},
      # Their names alone: a wheel with them is one of this machine's kind.
      ext_modules=[Extension("volute._core", []), Extension("volute._scene", [])])
