# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""`python -m volute` is the command `volute`."""
import os
import sys

from ._command import find


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
