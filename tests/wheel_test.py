#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""The wheel that `pip wheel ./python` makes of a build, in a new environment: `wheel_test.py ROOT BUILD`. The package, its command and
plug-ins come from the wheel, and NumPy from the system."""
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
READ = """
import os, sys, numpy, volute, volute._command
frames = numpy.zeros((2, 12, 12, 12), "f4")
frames[:, 3:9, 3:9, 3:9] = 1
volute.compress(frames, "f.volute", max_error=1e-3)
print(volute.picture("f.volute", size=(8, 6)).shape)
inside = os.path.dirname(volute.__file__)
assert inside.startswith(sys.prefix), inside
assert volute._command.find().startswith(inside), volute._command.find()
assert os.environ["VOLUTE_PLUGIN_FOLDER"].startswith(inside)
"""


def main():
    root, build = map(pathlib.Path, sys.argv[1:3])
    if not (build / "bin/volute").exists() or not list((build / "python/volute").glob("_core.*.so")):
        print("the command or the Python package is not built")
        return SKIPPED
    if not all(map(importlib.util.find_spec, ["numpy", "pip", "setuptools", "venv", "wheel", "ensurepip"])):
        print("it wants python3-numpy, python3-venv, python3-pip, python3-setuptools and python3-wheel")
        return SKIPPED
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        environment = {key: value for key, value in os.environ.items() if not key.startswith(("VOLUTE_", "PYTHON", "PIP_"))}

        def run(*command, **more):
            done = subprocess.run(list(map(str, command)), cwd=folder, text=True, capture_output=True, env=environment | more)
            if done.returncode != 0:
                sys.exit(f"{command}: {done.returncode}\n{done.stdout}{done.stderr}")
            return done.stdout

        source = folder / "source/python"  # what is built lies beside the sources
        shutil.copytree(root / "python", source, ignore=shutil.ignore_patterns("__pycache__", "build", "*.egg-info"))
        (folder / "source/src/volute/base").mkdir(parents=True)
        shutil.copy(root / "src/volute/base/version.hpp", folder / "source/src/volute/base")
        run(sys.executable, "-m", "pip", "wheel", "--no-build-isolation", "--no-deps", "-w", folder, source, VOLUTE_BUILD=str(build))
        run(sys.executable, "-m", "venv", "--system-site-packages", folder / "environment")
        python = folder / "environment/bin/python"
        run(python, "-m", "pip", "install", "--no-index", "--no-deps", next(folder.glob("volute-*.whl")))
        assert run(python, "-c", READ) == "(6, 8, 3)\n"
        command = folder / "environment/bin/volute"
        assert run(command, "--version").startswith("volute ")
        if (build / "lib/volute/volute_io_vdb.so").exists():
            run(command, "extract", "f.volute", "-o", "f_%04d.vdb")
            run(command, "info", "f_0000.vdb")
    print("wheel: ok")
    return 0


if __name__ == "__main__":
    sys.exit(main())
