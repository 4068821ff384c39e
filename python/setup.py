# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""The part of a wheel's build that pyproject.toml cannot say: CMake makes the extension modules."""
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
        subprocess.check_call(["cmake", "--build", build, "--target", "volute-python"])
        to = HERE / "volute" if self.inplace else pathlib.Path(self.build_lib) / "volute"
        to.mkdir(parents=True, exist_ok=True)
        for name in ["_core", "_scene"]:
            for module in (build / "python/volute").glob(f"{name}.*.so"):
                shutil.copy(module, to)


setup(version=VERSION, cmdclass={"build_ext": Cmake},
      # Their names alone: a wheel with them is one of this machine's kind.
      ext_modules=[Extension("volute._core", []), Extension("volute._scene", [])])
