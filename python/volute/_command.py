# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Where the program volute is."""
import os
import shutil


def find():
    """The program: what VOLUTE_COMMAND names, the wheel's, one beside this package (a build or an installed prefix), or the path's."""
    named = os.environ.get("VOLUTE_COMMAND")
    if named:
        return named
    folder = os.path.dirname(os.path.abspath(__file__))
    own = os.path.join(folder, "program", "bin", "volute")
    if os.access(own, os.X_OK):
        return own
    while os.path.dirname(folder) != folder:
        folder = os.path.dirname(folder)
        program = os.path.join(folder, "bin", "volute")
        if os.access(program, os.X_OK):
            return program
    return shutil.which("volute")
