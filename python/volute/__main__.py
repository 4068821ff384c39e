# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""`python -m volute` is the command `volute`."""
import os
import shutil
import sys


def find():
    """The program: what VOLUTE_COMMAND names, one beside this package (a build or an installed prefix), or the path's."""
    named = os.environ.get("VOLUTE_COMMAND")
    if named:
        return named
    folder = os.path.dirname(os.path.abspath(__file__))
    while os.path.dirname(folder) != folder:
        folder = os.path.dirname(folder)
        program = os.path.join(folder, "bin", "volute")
        if os.access(program, os.X_OK):
            return program
    return shutil.which("volute")


def main():
    program = find()
    if not program:
        sys.exit("python -m volute: the program volute is not there; install it (the package volute), or name it in VOLUTE_COMMAND")
    try:
        os.execv(program, [program] + sys.argv[1:])
    except OSError as error:
        sys.exit(f"python -m volute: cannot run {program}: {error.strerror}")


if __name__ == "__main__":
    main()
