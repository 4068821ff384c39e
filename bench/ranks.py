# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Runs the volute command, alone or by ranks of mpirun, for the measurements of this folder."""
import json
import os
import subprocess

# mpirun refuses root otherwise, which containers are.
ENVIRONMENT = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


def by_ranks(ranks, command):
    """A command line as strings, started by mpirun where it has more than one rank."""
    launcher = ["mpirun", "--oversubscribe", "-n", ranks] if ranks > 1 else []
    return [str(word) for word in (*launcher, *command)]


def stats_of(ranks, command, stats):
    """Runs a command, and returns what its --stats, a file of this name, says."""
    subprocess.run(by_ranks(ranks, [*command, "--stats", stats]), check=True, env=ENVIRONMENT, stdout=subprocess.DEVNULL)
    return json.loads(stats.read_text())
