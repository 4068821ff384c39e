# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""How long the rest takes: CPU time that was measured once, scaled by what this machine showed so far."""
import os
import time

# CPU seconds of `work_of_python` where the seconds of steps were measured.
REFERENCE = 0.065
# Of a program's CPU time, so many cores are busy at once: reading, writing and films are serial.
SERIAL_SHARE = 0.15


def work_of_python():
    begin = time.process_time()
    total = 0
    for i in range(3_000_000):
        total += i & 7
    return time.process_time() - begin


def cores():
    return len(os.sched_getaffinity(0))


def wall_share():
    """Wall time of a second of CPU time, by Amdahl's law."""
    return SERIAL_SHARE + (1 - SERIAL_SHARE) / cores()


class Forecast:
    """Wall seconds of steps and builds."""

    def __init__(self, slowness=None):
        """`slowness`: how many times slower than the reference a core is; measured when missing."""
        self.slowness = work_of_python() / REFERENCE if slowness is None else slowness
        self.expected, self.taken = 0.0, 0.0

    def seen(self, seconds, wall):
        """A step of so many reference seconds took so long."""
        if seconds > 0.2:
            self.expected += seconds * wall_share() * self.slowness
            self.taken += wall

    def factor(self):
        """What was taken of what was expected, trusted more the more was seen."""
        trust = 5.0  # seconds
        return (self.taken + trust) / (self.expected + trust)

    def wall(self, seconds):
        return seconds * wall_share() * self.slowness * self.factor()

    def compiling(self, seconds):
        """Compilers share nothing: all cores are busy."""
        return seconds * self.slowness / cores()


def spoken(seconds):
    """A duration as one says it."""
    if seconds < 10:
        return "a few seconds"
    if seconds < 90:
        return f"about {round(seconds / 5) * 5:.0f} seconds"
    return f"about {seconds / 60:.0f} minutes"
